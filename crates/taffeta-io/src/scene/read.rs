//! A serde reader over the document, so that every error is placed at the value or key that it is about.

use super::document::{Entry, Node, Path, Value};
use super::fault::{Fault, What};
use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error, IntoDeserializer, MapAccess, SeqAccess, VariantAccess,
    Visitor,
};
use serde::forward_to_deserialize_any;

/// A value and the way to it.
#[derive(Clone, Copy)]
pub(super) struct Reader<'a> {
    node: &'a Node,
    path: Path<'a>,
}

impl<'a> Reader<'a> {
    /// A reader of the whole document.
    pub fn of(root: &'a Node) -> Self {
        Self { node: root, path: Path::Root }
    }

    fn place<T>(self, result: Result<T, Fault>) -> Result<T, Fault> {
        result.map_err(|fault| fault.at_value(self.node, self.path))
    }

    fn visit<'de, V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match &self.node.value {
            Value::Text(text) | Value::Date(text) => visitor.visit_str(text),
            Value::Integer(number) => visitor.visit_i64(*number),
            Value::Number(number) => visitor.visit_f64(*number),
            Value::Truth(truth) => visitor.visit_bool(*truth),
            Value::Table(entries) => {
                visitor.visit_map(Entries { entries: entries.iter(), value: None, path: &self.path })
            }
            Value::List(items) => {
                let mut rest = Items { items: items.iter().enumerate(), path: &self.path };
                let list = visitor.visit_seq(&mut rest)?;
                match rest.items.len() {
                    0 => Ok(list),
                    extra => Err(Fault::of(What::Length {
                        found: items.len(),
                        expected: format!("a list of {} entries", items.len() - extra),
                    })),
                }
            }
        }
    }
}

impl<'de> Deserializer<'de> for Reader<'_> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.place(self.visit(visitor))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Fault> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match self.node.value {
            Value::Table(_) => self.deserialize_any(visitor),
            // Serde would take a list as the fields in order; a scene should name them.
            _ => self.place(Err(Fault::of(What::NotA(format!("struct {name}"))))),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        choices: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        let list = choices.join(", ");
        match &self.node.value {
            Value::Text(_) => self.place(visitor.visit_enum(Choice { of: self, entry: None })),
            Value::Table(entries) => match entries.as_slice() {
                [entry] => self.place(visitor.visit_enum(Choice { of: self, entry: Some(entry) })),
                [] => self.place(Err(Fault::custom(format!("needs one of: {list}")))),
                [first, second, ..] => Err(Fault::new(
                    second.key_origin,
                    format!(
                        "`{}` has both `{}` and `{}`; expected one of: {list}",
                        self.path, first.key, second.key
                    ),
                )),
            },
            _ => self.place(Err(Fault::of(What::NotA(format!("one of: {list}"))))),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct
        seq tuple tuple_struct map identifier ignored_any
    }
}

struct Items<'a> {
    items: std::iter::Enumerate<std::slice::Iter<'a, Node>>,
    path: &'a Path<'a>,
}

impl<'de> SeqAccess<'de> for &mut Items<'_> {
    type Error = Fault;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Fault> {
        let Some((index, node)) = self.items.next() else { return Ok(None) };
        seed.deserialize(Reader { node, path: Path::Index(self.path, index) }).map(Some)
    }
}

struct Entries<'a> {
    entries: std::slice::Iter<'a, Entry>,
    value: Option<&'a Entry>,
    path: &'a Path<'a>,
}

impl<'de> MapAccess<'de> for Entries<'_> {
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Fault> {
        self.value = self.entries.next();
        let Some(entry) = self.value else { return Ok(None) };
        let key = seed.deserialize(entry.key.as_str().into_deserializer());
        key.map(Some).map_err(|fault: Fault| fault.at_key(entry.key_origin, *self.path))
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, Fault> {
        let entry = self.value.take().ok_or_else(|| Fault::custom("a value was read before its key"))?;
        seed.deserialize(Reader { node: &entry.node, path: Path::Key(self.path, &entry.key) })
    }
}

/// One of several choices: a word, or a table with one key.
struct Choice<'a> {
    of: Reader<'a>,
    entry: Option<&'a Entry>,
}

impl<'de> EnumAccess<'de> for Choice<'_> {
    type Error = Fault;
    type Variant = Self;

    fn variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<(T::Value, Self), Fault> {
        let choice = match (self.entry, &self.of.node.value) {
            (Some(entry), _) => {
                let choice = seed.deserialize(entry.key.as_str().into_deserializer());
                choice.map_err(|fault: Fault| as_key(fault).at_key(entry.key_origin, self.of.path))
            }
            (None, Value::Text(word)) => seed.deserialize(word.as_str().into_deserializer()),
            (None, _) => Err(Fault::custom("is not a choice")),
        };
        Ok((choice?, self))
    }
}

/// In a table, the choice is a key.
fn as_key(fault: Fault) -> Fault {
    match fault.what {
        What::UnknownWord { word, valid } => Fault::of(What::UnknownKey { key: word, valid }),
        what => Fault { origin: fault.origin, what },
    }
}

impl<'de> VariantAccess<'de> for Choice<'_> {
    type Error = Fault;

    fn unit_variant(self) -> Result<(), Fault> {
        match self.entry {
            None => Ok(()),
            Some(_) => Err(Fault::of(What::NotA("a word in quotes".to_owned()))),
        }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Fault> {
        match self.entry {
            Some(entry) => {
                seed.deserialize(Reader { node: &entry.node, path: Path::Key(&self.of.path, &entry.key) })
            }
            None => Err(Fault::of(What::NotA("a table with that key".to_owned()))),
        }
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, _: V) -> Result<V::Value, Fault> {
        Err(Fault::custom("is not a choice"))
    }

    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], _: V) -> Result<V::Value, Fault> {
        Err(Fault::custom("is not a choice"))
    }
}
