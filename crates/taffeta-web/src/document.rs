//! Scenes as JavaScript has them (objects, lists, numbers, text, typed arrays) as TOML, which is what the engine's types are
//! read from.

use crate::errors::Failure;
use crate::mesh::{self, Arrays};
use crate::object::{Object, list};
use js_sys::{Array, Object as JsObject};
use toml::{Table, Value};
use wasm_bindgen::{JsCast, JsValue};

/// Deepest nesting: deeper ones are no scene, as an object that holds itself.
const DEEPEST: usize = 32;

/// A document, and the meshes in it that are given as arrays.
#[derive(Default)]
pub struct Document {
    pub table: Table,
    pub meshes: Vec<Arrays>,
}

impl Document {
    /// Reads an object.
    pub fn of(data: &JsValue) -> Result<Self, Failure> {
        let mut document = Self::default();
        match document.value(data, "", 0)? {
            Some(Value::Table(table)) => Ok(Self { table, ..document }),
            _ => Err(Failure::scene("a scene is TOML text, or an object with the keys of one")),
        }
    }

    /// A value at `path`; null and undefined are values that are not given.
    fn value(&mut self, value: &JsValue, path: &str, depth: usize) -> Result<Option<Value>, Failure> {
        if depth > DEEPEST {
            return Err(Failure::scene(format!("`{path}` is nested more than {DEEPEST} deep")));
        }
        if value.is_null() || value.is_undefined() {
            return Ok(None);
        }
        if let Some(boolean) = value.as_bool() {
            return Ok(Some(Value::Boolean(boolean)));
        }
        if let Some(number) = value.as_f64() {
            // What JavaScript writes without a point is whole, up to where numbers leave some out.
            let is_whole = number.fract() == 0.0 && number.abs() < 9e15;
            return Ok(Some(if is_whole { Value::Integer(number as i64) } else { Value::Float(number) }));
        }
        if let Some(text) = value.as_string() {
            return Ok(Some(Value::String(text)));
        }
        if value.is_bigint() {
            let whole = i64::try_from(value.clone());
            let whole = whole.map_err(|_| Failure::scene(format!("`{path}` does not fit 64 bits")))?;
            return Ok(Some(Value::Integer(whole)));
        }
        if Array::is_array(value) || mesh::is_typed(value) {
            return Ok(Some(Value::Array(self.list(&Array::from(value), path, depth)?)));
        }
        if !value.is_object() || value.is_function() {
            return Err(Failure::scene(format!(
                "`{path}` is a {}; a number, text, list, object or array would do",
                value.js_typeof().as_string().unwrap_or_default()
            )));
        }
        if mesh::is_key(path)
            && let Some(arrays) = Arrays::of(value, path)?
        {
            self.meshes.push(arrays);
            let name = mesh::stand_in(self.meshes.len() - 1);
            return Ok(Some(Value::Table(Table::from_iter([("file".to_owned(), Value::String(name))]))));
        }
        Ok(Some(Value::Table(self.table(value.unchecked_ref(), path, depth)?)))
    }

    fn table(&mut self, object: &JsObject, path: &str, depth: usize) -> Result<Table, Failure> {
        let mut table = Table::new();
        for entry in JsObject::entries(object).iter() {
            let entry: Array = entry.unchecked_into();
            let key = entry.get(0).as_string().unwrap_or_default();
            let dot = if path.is_empty() { "" } else { "." };
            if let Some(value) = self.value(&entry.get(1), &format!("{path}{dot}{key}"), depth + 1)? {
                table.insert(key, value);
            }
        }
        Ok(table)
    }

    fn list(&mut self, items: &Array, path: &str, depth: usize) -> Result<Vec<Value>, Failure> {
        let of = |(index, item): (usize, JsValue)| {
            let path = format!("{path}[{index}]");
            let value = self.value(&item, &path, depth + 1)?;
            value.ok_or_else(|| Failure::scene(format!("`{path}` is missing; a value would do")))
        };
        items.iter().enumerate().map(of).collect()
    }
}

/// A document in JavaScript's own types.
pub fn to_js(value: &Value) -> JsValue {
    match value {
        Value::String(text) => text.into(),
        Value::Integer(whole) => (*whole as f64).into(),
        Value::Float(number) => (*number).into(),
        Value::Boolean(boolean) => (*boolean).into(),
        Value::Datetime(date) => date.to_string().into(),
        Value::Array(items) => list(items.iter().map(to_js)),
        Value::Table(table) => {
            table.iter().fold(Object::new(), |object, (key, value)| object.with(key, to_js(value))).into()
        }
    }
}
