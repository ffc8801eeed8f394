//! A TOML document as a tree in which every value and key knows where it was written.

use super::fault::Fault;
use std::fmt;
use toml::de::{DeTable, DeValue};

/// Where something was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// Byte offset in the scene's text.
    File(usize),
    /// Index of the override.
    Set(usize),
}

/// A value and its origin.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub origin: Origin,
    pub value: Value,
}

#[derive(Clone, Debug)]
pub(super) enum Value {
    Text(String),
    Integer(i64),
    Number(f64),
    Truth(bool),
    Date(String),
    List(Vec<Node>),
    Table(Vec<Entry>),
}

#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub key: String,
    pub key_origin: Origin,
    pub node: Node,
}

/// Keys and indices from the root, for messages: `body[0].springs.structural.k`.
#[derive(Clone, Copy)]
pub(super) enum Path<'a> {
    Root,
    Key(&'a Path<'a>, &'a str),
    Index(&'a Path<'a>, usize),
}

impl fmt::Display for Path<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Path::Root => Ok(()),
            Path::Key(Path::Root, key) => f.write_str(key),
            Path::Key(parent, key) => write!(f, "{parent}.{key}"),
            Path::Index(parent, index) => write!(f, "{parent}[{index}]"),
        }
    }
}

impl fmt::Display for Node {
    /// The value in words: `text "abc"`, `a list of 2`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.value {
            Value::Text(text) if text.chars().count() > 40 => f.write_str("a long text"),
            Value::Text(text) => write!(f, "the text {text:?}"),
            Value::Integer(number) => write!(f, "{number}"),
            Value::Number(number) => write!(f, "{number:?}"),
            Value::Truth(truth) => write!(f, "{truth}"),
            Value::Date(date) => write!(f, "the date {date}"),
            Value::List(items) => write!(f, "a list of {}", items.len()),
            Value::Table(_) => f.write_str("a table"),
        }
    }
}

/// Parses a whole document.
pub(super) fn parse(text: &str) -> Result<Node, Fault> {
    let table = DeTable::parse(text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start);
        Fault::new(Origin::File(start), format!("not valid TOML: {}", error.message()))
    })?;
    let entries = convert_table(table.get_ref(), Path::Root, &Origin::File)?;
    Ok(Node { origin: Origin::File(0), value: Value::Table(entries) })
}

/// Parses the value of an override; what is not TOML is taken as text.
pub(super) fn parse_set_value(text: &str, path: &str, index: usize) -> Result<Node, Fault> {
    match DeValue::parse(text) {
        Ok(value) => convert(value.get_ref(), 0, Path::Key(&Path::Root, path), &|_| Origin::Set(index)),
        Err(_) => Ok(Node { origin: Origin::Set(index), value: Value::Text(text.to_owned()) }),
    }
}

fn convert_table(table: &DeTable, path: Path, origin: &dyn Fn(usize) -> Origin) -> Result<Vec<Entry>, Fault> {
    let mut spans: Vec<_> = table.iter().collect();
    // The file's order, so that the first mistake in the file is the one that is reported.
    spans.sort_by_key(|(key, _)| key.span().start);
    let entry = |(key, value): (&toml::Spanned<_>, &toml::Spanned<DeValue>)| {
        let name: &std::borrow::Cow<str> = key.get_ref();
        let node = convert(value.get_ref(), value.span().start, Path::Key(&path, name), origin)?;
        Ok(Entry { key: name.clone().into_owned(), key_origin: origin(key.span().start), node })
    };
    spans.into_iter().map(entry).collect()
}

fn convert(
    value: &DeValue,
    start: usize,
    path: Path,
    origin: &dyn Fn(usize) -> Origin,
) -> Result<Node, Fault> {
    let refuse = |what: String| Err(Fault::new(origin(start), format!("`{path}`: {what}")));
    let value = match value {
        DeValue::String(text) => Value::Text(text.clone().into_owned()),
        DeValue::Integer(digits) => match i64::from_str_radix(digits.as_str(), digits.radix()) {
            Ok(number) => Value::Integer(number),
            Err(_) => return refuse(format!("{digits} does not fit 64 bits")),
        },
        DeValue::Float(digits) => match digits.as_str().parse::<f64>() {
            Ok(number) if number.is_finite() => Value::Number(number),
            _ => return refuse(format!("{digits} is not a finite number")),
        },
        DeValue::Boolean(truth) => Value::Truth(*truth),
        DeValue::Datetime(date) => Value::Date(date.to_string()),
        DeValue::Array(items) => Value::List(
            items
                .iter()
                .enumerate()
                .map(|(i, item)| convert(item.get_ref(), item.span().start, Path::Index(&path, i), origin))
                .collect::<Result<_, _>>()?,
        ),
        DeValue::Table(table) => Value::Table(convert_table(table, path, origin)?),
    };
    Ok(Node { origin: origin(start), value })
}
