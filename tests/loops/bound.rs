//! Whether a value has a bound that the program gives.

use naga::{
    AddressSpace, BinaryOperator, Block, Expression, Function, Handle, LocalVariable, MathFunction, Module, Statement,
};
use std::collections::HashSet;

/// A function of a module: an ordinary one, or an entry point.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub enum Place {
    /// One that others call.
    Function(Handle<Function>),
    /// By its index.
    Entry(usize),
}

/// All places of a module.
pub fn places(module: &Module) -> Vec<Place> {
    let functions = module.functions.iter().map(|(handle, _)| Place::Function(handle));
    functions.chain((0..module.entry_points.len()).map(Place::Entry)).collect()
}

/// The function at a place.
pub fn function(module: &Module, place: Place) -> &Function {
    match place {
        Place::Function(handle) => &module.functions[handle],
        Place::Entry(index) => &module.entry_points[index].function,
    }
}

/// Calls `visit` with every statement of a block and of the blocks in it.
pub fn visit<'m>(block: &'m Block, visit_one: &mut dyn FnMut(&'m Statement)) {
    for statement in block {
        visit_one(statement);
        match statement {
            Statement::Block(inner) => visit(inner, visit_one),
            Statement::If { accept, reject, .. } => {
                visit(accept, visit_one);
                visit(reject, visit_one);
            }
            Statement::Switch { cases, .. } => cases.iter().for_each(|case| visit(&case.body, visit_one)),
            Statement::Loop { body, continuing, .. } => {
                visit(body, visit_one);
                visit(continuing, visit_one);
            }
            _ => {}
        }
    }
}

/// The variable that a pointer points into.
pub enum Base {
    /// One of the function.
    Local(Handle<LocalVariable>),
    /// One of the module.
    Global(Handle<naga::GlobalVariable>),
    /// One of a caller.
    Argument,
}

/// Follows a pointer to its variable.
pub fn base(function: &Function, mut pointer: Handle<Expression>) -> Option<Base> {
    loop {
        match function.expressions[pointer] {
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => pointer = base,
            Expression::LocalVariable(local) => return Some(Base::Local(local)),
            Expression::GlobalVariable(global) => return Some(Base::Global(global)),
            Expression::FunctionArgument(_) => return Some(Base::Argument),
            _ => return None,
        }
    }
}

/// Values that are stored in a local variable or a part of it; `None` if others than stores
/// may change it.
pub fn stored(function: &Function, local: Handle<LocalVariable>) -> Option<Vec<Handle<Expression>>> {
    let is_it = |pointer| matches!(base(function, pointer), Some(Base::Local(found)) if found == local);
    let (mut values, mut only_stores) = (Vec::new(), true);
    values.extend(function.local_variables[local].init);
    visit(&function.body, &mut |statement| match statement {
        Statement::Store { pointer, value } if is_it(*pointer) => values.push(*value),
        Statement::Call { arguments, .. } if arguments.iter().any(|a| is_it(*a)) => only_stores = false,
        _ => {}
    });
    only_stores.then_some(values)
}

/// Why a value has no bound: what it comes from.
pub type Unbounded = String;

/// Looks for where values come from.
pub struct Bounds<'m> {
    module: &'m Module,
    /// What is being looked at: a value that depends on itself has the bound of the rest.
    seen: HashSet<(Place, Handle<Expression>)>,
}

impl<'m> Bounds<'m> {
    /// Bounds of a module's values.
    pub fn new(module: &'m Module) -> Self {
        Self { module, seen: HashSet::new() }
    }

    /// Errors unless the value has a bound.
    pub fn check(&mut self, place: Place, expression: Handle<Expression>) -> Result<(), Unbounded> {
        if !self.seen.insert((place, expression)) {
            return Ok(());
        }
        let function = function(self.module, place);
        match &function.expressions[expression] {
            Expression::Literal(_)
            | Expression::Constant(_)
            | Expression::Override(_)
            | Expression::ZeroValue(_)
            | Expression::ImageQuery { .. }
            | Expression::ArrayLength(_)
            | Expression::Relational { .. } => Ok(()),
            Expression::Compose { components, .. } => self.all(place, components),
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => self.check(place, *base),
            Expression::Splat { value, .. } | Expression::Swizzle { vector: value, .. } => self.check(place, *value),
            Expression::Unary { expr, .. } | Expression::As { expr, .. } => self.check(place, *expr),
            Expression::Load { pointer } => self.check(place, *pointer),
            Expression::Select { accept, reject, .. } => self.all(place, &[*accept, *reject]),
            Expression::Binary { op, left, right } => match op {
                BinaryOperator::Modulo => self.check(place, *right),
                BinaryOperator::And => self.any(place, &[*left, *right]),
                BinaryOperator::ShiftRight => self.check(place, *left),
                _ => self.all(place, &[*left, *right]),
            },
            Expression::Math { fun, arg, arg1, arg2, arg3 } => {
                let arguments: Vec<_> = [Some(*arg), *arg1, *arg2, *arg3].into_iter().flatten().collect();
                match fun {
                    MathFunction::Min => self.any(place, &arguments),
                    MathFunction::Clamp => self.any(place, &[*arg, arguments[2]]),
                    MathFunction::CountLeadingZeros
                    | MathFunction::CountTrailingZeros
                    | MathFunction::CountOneBits
                    | MathFunction::Saturate
                    | MathFunction::Sign => Ok(()),
                    _ => self.all(place, &arguments),
                }
            }
            Expression::FunctionArgument(index) => self.argument(place, *index),
            Expression::LocalVariable(local) => {
                let name = function.local_variables[*local].name.clone().unwrap_or_default();
                let values = stored(function, *local).ok_or(format!("{name}, which a call may change"))?;
                self.all(place, &values)
            }
            Expression::GlobalVariable(global) => self.global(*global),
            Expression::CallResult(called) => {
                let mut returned = Vec::new();
                visit(&self.module.functions[*called].body, &mut |statement| {
                    if let Statement::Return { value: Some(value) } = statement {
                        returned.push(*value);
                    }
                });
                self.all(Place::Function(*called), &returned)
            }
            other => Err(format!("{other:?}").chars().take(60).collect()),
        }
    }

    fn all(&mut self, place: Place, values: &[Handle<Expression>]) -> Result<(), Unbounded> {
        values.iter().try_for_each(|value| self.check(place, *value))
    }

    fn any(&mut self, place: Place, values: &[Handle<Expression>]) -> Result<(), Unbounded> {
        let mut last = Ok(());
        for value in values {
            // What was seen on the way to a value without a bound proves nothing later on.
            let before = self.seen.clone();
            last = self.check(place, *value);
            if last.is_ok() {
                return last;
            }
            self.seen = before;
        }
        last
    }

    /// Of an argument all that callers pass; of an entry point what the GPU does.
    fn argument(&mut self, place: Place, index: u32) -> Result<(), Unbounded> {
        let Place::Function(called) = place else { return Ok(()) };
        for caller in places(self.module) {
            let mut passed = Vec::new();
            visit(&function(self.module, caller).body, &mut |statement| {
                if let Statement::Call { function, arguments, .. } = statement
                    && *function == called
                {
                    passed.push(arguments[index as usize]);
                }
            });
            self.all(caller, &passed)?;
        }
        Ok(())
    }

    fn global(&mut self, global: Handle<naga::GlobalVariable>) -> Result<(), Unbounded> {
        let variable = &self.module.global_variables[global];
        match variable.space {
            AddressSpace::Uniform => Ok(()),
            AddressSpace::WorkGroup | AddressSpace::Private => {
                for place in places(self.module) {
                    let function = function(self.module, place);
                    let is_it =
                        |pointer| matches!(base(function, pointer), Some(Base::Global(found)) if found == global);
                    let mut values = Vec::new();
                    visit(&function.body, &mut |statement| match statement {
                        Statement::Store { pointer, value } if is_it(*pointer) => values.push(*value),
                        Statement::Atomic { pointer, value, .. } if is_it(*pointer) => values.push(*value),
                        _ => {}
                    });
                    self.all(place, &values)?;
                }
                Ok(())
            }
            _ => Err(format!("what {} holds", variable.name.as_deref().unwrap_or("a buffer or texture"))),
        }
    }
}
