//! Whether loops end.

use super::bound::{Base, Bounds, Place, base, function, places, stored, visit};
use naga::{
    BinaryOperator, Block, Expression, Function, Handle, Literal, LocalVariable, Module, ScalarKind, Span, Statement,
    TypeInner,
};

/// Loops of a module, and what is wrong with those that are not proved to end.
pub fn unproved(module: &Module, source: &str) -> (usize, Vec<String>) {
    let (mut count, mut wrong) = (0, Vec::new());
    for place in places(module) {
        let of = Proof { module, place, function: function(module, place) };
        of.loops(&of.function.body, &mut |at, result| {
            count += 1;
            if let Err(reason) = result {
                let line = source.get(..at.to_range().map_or(0, |r| r.start)).map_or(0, |s| s.lines().count());
                wrong.push(format!("line {line} with its imports: {reason}"));
            }
        });
    }
    (count, wrong)
}

struct Proof<'m> {
    module: &'m Module,
    place: Place,
    function: &'m Function,
}

impl Proof<'_> {
    fn loops(&self, block: &Block, tell: &mut dyn FnMut(Span, Result<(), String>)) {
        for (statement, span) in block.span_iter() {
            match statement {
                Statement::Loop { body, continuing, break_if } => {
                    tell(*span, self.ends(body, continuing, *break_if));
                    self.loops(body, tell);
                    self.loops(continuing, tell);
                }
                Statement::Block(inner) => self.loops(inner, tell),
                Statement::If { accept, reject, .. } => {
                    self.loops(accept, tell);
                    self.loops(reject, tell);
                }
                Statement::Switch { cases, .. } => cases.iter().for_each(|case| self.loops(&case.body, tell)),
                _ => {}
            }
        }
    }

    fn ends(&self, body: &Block, continuing: &Block, break_if: Option<Handle<Expression>>) -> Result<(), String> {
        if break_if.is_some() {
            return Err("it ends by `break if`, which nothing is known of here".into());
        }
        let conditions = self.conditions(body);
        if conditions.is_empty() {
            return Err("it begins with no condition to go on".into());
        }
        let mut reasons = Vec::new();
        for condition in conditions {
            match self.fails_at_last(condition, body, continuing) {
                Ok(()) => return Ok(()),
                Err(reason) => reasons.push(reason),
            }
        }
        Err(reasons.join("; "))
    }

    /// Conditions with which each round begins: if one fails, the loop ends.
    fn conditions(&self, body: &Block) -> Vec<Handle<Expression>> {
        let is_break = |block: &Block| matches!(block.last(), Some(Statement::Break)) && block.len() == 1;
        // Both sides of `a && b` are found as naga takes it apart: if a { t = b } else { t = false }.
        let mut both = Vec::new();
        for statement in body {
            match statement {
                Statement::Emit(_) => {}
                Statement::If { condition, accept, reject } if accept.is_empty() && is_break(reject) => {
                    let mut found = vec![*condition];
                    let mut next = 0;
                    while next < found.len() {
                        found.extend(self.parts_of(found[next], &both));
                        next += 1;
                    }
                    return found;
                }
                Statement::If { condition, accept, reject } => {
                    let [Some((t, b)), Some((u, f))] = [self.last_store(accept), self.last_store(reject)] else {
                        return Vec::new();
                    };
                    let is_false = matches!(self.function.expressions[f], Expression::Literal(Literal::Bool(false)));
                    if t != u || !is_false {
                        return Vec::new();
                    }
                    both.push((t, [*condition, b]));
                }
                _ => return Vec::new(),
            }
        }
        Vec::new()
    }

    fn parts_of(
        &self,
        condition: Handle<Expression>,
        both: &[(Handle<LocalVariable>, [Handle<Expression>; 2])],
    ) -> Vec<Handle<Expression>> {
        match self.function.expressions[condition] {
            Expression::Binary { op: BinaryOperator::LogicalAnd, left, right } => vec![left, right],
            Expression::Load { pointer } => {
                let Some(Base::Local(local)) = base(self.function, pointer) else { return Vec::new() };
                both.iter().filter(|(t, _)| *t == local).flat_map(|(_, parts)| *parts).collect()
            }
            _ => Vec::new(),
        }
    }

    /// The local variable and the value of the store that a block ends with.
    fn last_store(&self, block: &Block) -> Option<(Handle<LocalVariable>, Handle<Expression>)> {
        let Some(Statement::Store { pointer, value }) = block.last() else { return None };
        match self.function.expressions[*pointer] {
            Expression::LocalVariable(local) => Some((local, *value)),
            _ => None,
        }
    }

    /// Whether a condition fails after finitely many rounds.
    fn fails_at_last(&self, condition: Handle<Expression>, body: &Block, continuing: &Block) -> Result<(), String> {
        let Expression::Binary { op, left, right } = self.function.expressions[condition] else {
            return Err("a condition that is no comparison".into());
        };
        let (counter, end) = match op {
            BinaryOperator::Less | BinaryOperator::LessEqual => (left, right),
            BinaryOperator::Greater | BinaryOperator::GreaterEqual => (right, left),
            BinaryOperator::NotEqual => return self.clears_bits(left, body),
            _ => return Err("a comparison that is neither an order nor != 0".into()),
        };
        let counter = self.variable(counter).ok_or("what is compared is not a variable")?;
        let variable = &self.function.local_variables[counter];
        let name = variable.name.clone().unwrap_or_default();
        // A float stops growing where it is large, and never meets an infinite end.
        let is_float =
            matches!(self.module.types[variable.ty].inner, TypeInner::Scalar(s) if s.kind == ScalarKind::Float);
        if is_float {
            return Err(format!("{name} is a float"));
        }
        self.grows(counter, body, continuing).map_err(|reason| format!("{name} {reason}"))?;
        Bounds::new(self.module)
            .check(self.place, end)
            .map_err(|reason| format!("the end of {name} depends on {reason}"))
    }

    /// The local variable that an expression reads.
    fn variable(&self, expression: Handle<Expression>) -> Option<Handle<LocalVariable>> {
        let Expression::Load { pointer } = self.function.expressions[expression] else { return None };
        match self.function.expressions[pointer] {
            Expression::LocalVariable(local) => Some(local),
            _ => None,
        }
    }

    /// Errors unless each round makes the variable greater, and nothing else changes it.
    fn grows(&self, counter: Handle<LocalVariable>, body: &Block, continuing: &Block) -> Result<(), String> {
        let changed = stored(self.function, counter).ok_or("may be changed by a call")?;
        let stores = |block: &Block| {
            let mut values = Vec::new();
            visit(block, &mut |statement| {
                if let Statement::Store { pointer, value } = statement
                    && matches!(base(self.function, *pointer), Some(Base::Local(found)) if found == counter)
                {
                    values.push(*value);
                }
            });
            values
        };
        let (mut all, last) = (stores(body), stores(continuing));
        all.extend(&last);
        let [step] = all[..] else { return Err(format!("changes in {} places", all.len())) };
        // A step in the body counts if nothing can go round it.
        let passed = match last[..] {
            [_] => continuing.iter().any(|s| matches!(s, Statement::Store { value, .. } if *value == step)),
            _ => self.is_passed(body, step),
        };
        if !passed {
            return Err("does not change in every round".into());
        }
        let Expression::Binary { op, left, right } = self.function.expressions[step] else {
            return Err("changes by something else than a sum or a product".into());
        };
        if self.variable(left) != Some(counter) {
            return Err("changes to something that it does not begin with".into());
        }
        let by = self.constant(right).ok_or("changes by something that is no constant")?;
        match op {
            BinaryOperator::Add if by > 0.0 => Ok(()),
            BinaryOperator::Multiply if by > 1.0 => {
                let starts: Vec<_> = changed.iter().filter(|value| **value != step).collect();
                let positive = starts.iter().all(|value| self.constant(**value).is_some_and(|v| v > 0.0));
                if positive && !starts.is_empty() { Ok(()) } else { Err("is multiplied and may begin at 0".into()) }
            }
            _ => Err("does not grow".into()),
        }
    }

    /// Whether every round that does not end the loop gets to the statement that stores
    /// `value`: it stands before any `continue`.
    fn is_passed(&self, body: &Block, value: Handle<Expression>) -> bool {
        for statement in body {
            match statement {
                Statement::Store { value: found, .. } if *found == value => return true,
                // A block of its own, as the bodies of `for` and `while` are.
                Statement::Block(inner) => return self.is_passed(inner, value),
                _ => {
                    let mut goes_on = false;
                    let one = Block::from_vec(vec![statement.clone()]);
                    visit(&one, &mut |s| goes_on |= matches!(s, Statement::Continue));
                    if goes_on {
                        return false;
                    }
                }
            }
        }
        false
    }

    /// A scalar number known from the shader's text.
    fn constant(&self, expression: Handle<Expression>) -> Option<f64> {
        match self.function.expressions[expression] {
            Expression::Literal(literal) => number(literal),
            Expression::Constant(constant) => {
                match self.module.global_expressions[self.module.constants[constant].init] {
                    Expression::Literal(literal) => number(literal),
                    _ => None,
                }
            }
            _ => None,
        }
    }

    /// Errors unless each round clears the lowest bit of what is compared with 0.
    fn clears_bits(&self, bits: Handle<Expression>, body: &Block) -> Result<(), String> {
        let bits = self.variable(bits).ok_or("what is compared with != is not a variable")?;
        let mut stores = Vec::new();
        visit(body, &mut |statement| {
            if let Statement::Store { pointer, value } = statement
                && matches!(base(self.function, *pointer), Some(Base::Local(found)) if found == bits)
            {
                stores.push(*value);
            }
        });
        let [value] = stores[..] else { return Err("bits are changed in several places or nowhere".into()) };
        let is_one_less = |expression: Handle<Expression>| {
            matches!(self.function.expressions[expression], Expression::Binary { op: BinaryOperator::Subtract, left, right }
                if self.variable(left) == Some(bits) && self.constant(right) == Some(1.0))
        };
        match self.function.expressions[value] {
            Expression::Binary { op: BinaryOperator::And, left, right }
                if self.variable(left) == Some(bits) && is_one_less(right) && self.is_passed(body, value) =>
            {
                Ok(())
            }
            _ => Err("bits are not cleared one by one in every round".into()),
        }
    }
}

fn number(literal: Literal) -> Option<f64> {
    match literal {
        Literal::F32(v) => Some(v.into()),
        Literal::U32(v) => Some(v.into()),
        Literal::I32(v) => Some(v.into()),
        _ => None,
    }
}
