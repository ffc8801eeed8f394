//! Values that features keep where they are shared: one of each type.

use std::any::{Any, TypeId};

/// One value of each type: a handful, so that a search is faster than a hash.
#[derive(Default)]
pub struct Extensions(Vec<(TypeId, Box<dyn Any + Send + Sync>)>);

impl Extensions {
    /// Keeps a value, in place of another one of its type.
    pub fn insert<V: Any + Send + Sync>(&mut self, value: V) {
        match self.place(TypeId::of::<V>()) {
            Some(place) => self.0[place].1 = Box::new(value),
            None => self.0.push((TypeId::of::<V>(), Box::new(value))),
        }
    }

    /// Keeps a list that is not empty: one without items need not be looked at.
    pub fn insert_list<V: Any + Send + Sync>(&mut self, list: Vec<V>) {
        if !list.is_empty() {
            self.insert(list);
        }
    }

    /// The value of a type, if there is one.
    pub fn get<V: Any>(&self) -> Option<&V> {
        self.0[self.place(TypeId::of::<V>())?].1.downcast_ref()
    }

    /// The values of a list; none if there is no list.
    pub fn list<V: Any>(&self) -> &[V] {
        self.get::<Vec<V>>().map_or(&[], Vec::as_slice)
    }

    /// The value of a type, which is its default if there was none.
    pub fn get_mut<V: Any + Default + Send + Sync>(&mut self) -> &mut V {
        let place = self.place(TypeId::of::<V>()).unwrap_or_else(|| {
            self.0.push((TypeId::of::<V>(), Box::new(V::default())));
            self.0.len() - 1
        });
        self.0[place].1.downcast_mut().expect("a value is kept by its own type")
    }

    fn place(&self, of: TypeId) -> Option<usize> {
        self.0.iter().position(|&(it, _)| it == of)
    }
}
