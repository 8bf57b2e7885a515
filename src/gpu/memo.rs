//! A cache of values that are computed from parameters, such as tables of apertures.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Values kept of one kind: a comparison alternates between few apertures and lenses.
const KEPT: usize = 16;

/// Values by their parameters. Of each kind (pair of types) the ones used last are kept.
#[derive(Default)]
pub struct Memo(Mutex<HashMap<TypeId, Box<dyn Any + Send>>>);

/// Parameters and values of one kind, the one used last at the end.
type Entries<K, V> = Vec<(K, Arc<V>)>;

impl Memo {
    /// The value for `key`, made by `make` where it is not known.
    pub fn get<K, V>(&self, key: &K, make: impl FnOnce() -> V) -> Arc<V>
    where
        K: PartialEq + Clone + Send + 'static,
        V: Send + Sync + 'static,
    {
        let kind = TypeId::of::<(K, V)>();
        let known = self.entries::<K, V, _>(kind, |entries| {
            let found = entries.iter().position(|(k, _)| k == key)?;
            let entry = entries.remove(found);
            let value = entry.1.clone();
            entries.push(entry);
            Some(value)
        });
        if let Some(value) = known {
            return value;
        }
        // Not while locked: it may take long and ask for other values.
        let value = Arc::new(make());
        self.entries::<K, V, _>(kind, |entries| {
            if entries.len() == KEPT {
                entries.remove(0);
            }
            entries.push((key.clone(), value.clone()));
        });
        value
    }

    fn entries<K, V, R>(&self, kind: TypeId, act: impl FnOnce(&mut Entries<K, V>) -> R) -> R
    where
        K: Send + 'static,
        V: Send + Sync + 'static,
    {
        let mut kinds = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let entries = kinds.entry(kind).or_insert_with(|| Box::new(Entries::<K, V>::new()));
        act(entries.downcast_mut().expect("the entries of a kind are of that kind"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_made_once_and_the_oldest_go() {
        let memo = Memo::default();
        let mut made = Vec::new();
        for key in (0..KEPT as u32).chain([0, 100, 1, 0]) {
            assert_eq!(
                *memo.get(&key, || {
                    made.push(key);
                    2 * key
                }),
                2 * key
            );
        }
        // 0 was used again before 100 came: 1 had to go.
        assert_eq!(made[KEPT..], [100, 1]);
        assert_eq!(*memo.get(&1u32, || "another kind"), "another kind");
    }
}
