//! Scenes as Python has them (dicts, lists, numbers, text, arrays) as TOML, which is what the engine's types are read from.

use crate::errors::Failure;
use crate::mesh::{self, Given};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyBytes, PyDict, PyFloat, PyInt, PyList, PyMapping, PySequence, PyString};
use toml::{Table, Value};

/// Deepest nesting: deeper ones are no scene, as a list that holds itself.
const DEEPEST: usize = 32;

/// A document, and the meshes in it that are given as arrays.
#[derive(Default)]
pub struct Document {
    pub table: Table,
    pub meshes: Vec<Given>,
    /// Whether these are left out, where only the rest is to be looked at.
    skips_arrays: bool,
}

impl Document {
    /// Reads a dict.
    pub fn of(data: &Bound<'_, PyAny>, skips_arrays: bool) -> Result<Self, Failure> {
        let mut document = Self { skips_arrays, ..Self::default() };
        match document.value(data, "", 0)? {
            Some(Value::Table(table)) => Ok(Self { table, ..document }),
            _ => Err(Failure::scene("a scene is a dict with words as keys")),
        }
    }

    /// A value at `path`; `None` is a value that is not given.
    fn value(
        &mut self,
        value: &Bound<'_, PyAny>,
        path: &str,
        depth: usize,
    ) -> Result<Option<Value>, Failure> {
        if depth > DEEPEST {
            return Err(Failure::scene(format!("`{path}` is nested more than {DEEPEST} deep")));
        }
        if value.is_none() {
            return Ok(None);
        }
        if is_mesh_key(path) && Given::is_mesh(value)? {
            if !self.skips_arrays {
                self.meshes.extend(Given::of(value, path)?);
            }
            let name = mesh::stand_in(self.meshes.len().saturating_sub(1));
            return Ok(Some(Value::Table(Table::from_iter([("file".to_owned(), Value::String(name))]))));
        }
        if let Some(plain) = plain(value, path)? {
            return Ok(Some(plain));
        }
        if let Ok(mapping) = value.cast::<PyMapping>() {
            return Ok(Some(Value::Table(self.table(mapping, path, depth)?)));
        }
        // Arrays and numbers of numpy and others say what they are in Python's own.
        if value.hasattr("tolist")? {
            return self.value(&value.call_method0("tolist")?, path, depth + 1);
        }
        if let Ok(items) = value.cast::<PySequence>() {
            return Ok(Some(Value::Array(self.list(items, path, depth)?)));
        }
        // Fractions, decimals and what else is a number.
        if let Ok(number) = value.extract::<f64>() {
            return Ok(Some(Value::Float(number)));
        }
        Err(unfit(value, path))
    }

    fn table(&mut self, mapping: &Bound<'_, PyMapping>, path: &str, depth: usize) -> Result<Table, Failure> {
        let mut table = Table::new();
        for item in mapping.items()?.iter() {
            let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
            let Ok(key) = key.extract::<String>() else {
                let place = if path.is_empty() { String::new() } else { format!("`{path}`: ") };
                return Err(Failure::scene(format!("{place}the key {} is no text", shown(&key))));
            };
            let dot = if path.is_empty() { "" } else { "." };
            if let Some(value) = self.value(&value, &format!("{path}{dot}{key}"), depth + 1)? {
                table.insert(key, value);
            }
        }
        Ok(table)
    }

    fn list(
        &mut self,
        items: &Bound<'_, PySequence>,
        path: &str,
        depth: usize,
    ) -> Result<Vec<Value>, Failure> {
        let mut list = Vec::with_capacity(items.len()?);
        for (index, item) in items.try_iter()?.enumerate() {
            let path = format!("{path}[{index}]");
            let value = self.value(&item?, &path, depth + 1)?;
            list.push(value.ok_or_else(|| Failure::scene(format!("`{path}` is None; a value would do")))?);
        }
        Ok(list)
    }
}

/// Whether a mesh may be given by arrays at a path.
fn is_mesh_key(path: &str) -> bool {
    let last = path.rsplit('.').next().unwrap_or_default();
    last == "mesh" || last == "convex"
}

/// A boolean, a number or a text.
fn plain(value: &Bound<'_, PyAny>, path: &str) -> Result<Option<Value>, Failure> {
    if let Ok(boolean) = value.cast::<PyBool>() {
        return Ok(Some(Value::Boolean(boolean.is_true())));
    }
    if value.is_instance_of::<PyInt>() {
        let whole = value.extract::<i64>();
        let whole =
            whole.map_err(|_| Failure::scene(format!("`{path}`: {} does not fit 64 bits", shown(value))));
        return whole.map(|whole| Some(Value::Integer(whole)));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Some(Value::Float(value.extract()?)));
    }
    if value.is_instance_of::<PyString>() {
        let text = value.extract::<String>();
        let text = text.map_err(|_| Failure::scene(format!("`{path}`: the text is not Unicode")));
        return text.map(|text| Some(Value::String(text)));
    }
    if value.is_instance_of::<PyBytes>() {
        return Err(unfit(value, path));
    }
    if value.hasattr("__fspath__")? {
        let text = value.call_method0("__fspath__")?;
        return text.extract().map(|text| Some(Value::String(text))).map_err(|_| unfit(value, path));
    }
    Ok(None)
}

fn unfit(value: &Bound<'_, PyAny>, path: &str) -> Failure {
    let kind = value.get_type().name().map_or_else(|_| "object".to_owned(), |name| name.to_string());
    Failure::scene(format!(
        "`{path}` is {}, of type {kind}; a number, text, list, dict or array would do",
        shown(value)
    ))
}

/// A value for people, cut short.
fn shown(value: &Bound<'_, PyAny>) -> String {
    let text = value.repr().map_or_else(|_| "?".to_owned(), |text| text.to_string());
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// A document in Python's own types.
pub fn to_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::String(text) => PyString::new(py, text).into_any(),
        Value::Integer(whole) => whole.into_pyobject(py)?.into_any(),
        Value::Float(number) => PyFloat::new(py, *number).into_any(),
        Value::Boolean(boolean) => PyBool::new(py, *boolean).to_owned().into_any(),
        Value::Datetime(date) => PyString::new(py, &date.to_string()).into_any(),
        Value::Array(items) => {
            let list = PyList::empty(py);
            items.iter().try_for_each(|item| list.append(to_python(py, item)?))?;
            list.into_any()
        }
        Value::Table(table) => {
            let dict = PyDict::new(py);
            table.iter().try_for_each(|(key, value)| dict.set_item(key, to_python(py, value)?))?;
            dict.into_any()
        }
    })
}
