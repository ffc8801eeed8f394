//! Values that features keep where they are shared: one of each type.

use std::any::{Any, TypeId};
use std::collections::HashMap;

/// One value of each type.
#[derive(Default)]
pub struct Extensions(HashMap<TypeId, Box<dyn Any + Send + Sync>>);

impl Extensions {
    /// Keeps a value, in place of another one of its type.
    pub fn insert<V: Any + Send + Sync>(&mut self, value: V) {
        self.0.insert(TypeId::of::<V>(), Box::new(value));
    }

    /// The value of a type, if there is one.
    pub fn get<V: Any>(&self) -> Option<&V> {
        self.0.get(&TypeId::of::<V>())?.downcast_ref()
    }

    /// The values of a list; none if there is no list.
    pub fn list<V: Any>(&self) -> &[V] {
        self.get::<Vec<V>>().map_or(&[], Vec::as_slice)
    }

    /// The value of a type, which is its default if there was none.
    pub fn get_mut<V: Any + Default + Send + Sync>(&mut self) -> &mut V {
        let value = self.0.entry(TypeId::of::<V>()).or_insert_with(|| Box::new(V::default()));
        value.downcast_mut().expect("a value is kept by its own type")
    }
}
