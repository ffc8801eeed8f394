//! Overrides, `PATH=VALUE`: each changes one value of a document. Elements of lists go by `name` or by index.

use super::document::{Entry, Node, Origin, Value, parse_set_value};
use super::fault::Fault;
use super::words::nearest_of;

/// Most steps of a path; deeper ones lead nowhere.
const DEEPEST: usize = 32;

/// Applies the override number `index`, `body.flag.springs.structural.k=500`.
pub(super) fn apply(root: &mut Node, index: usize, text: &str) -> Result<(), Fault> {
    let origin = Origin::Set(index);
    let refuse = |message: String| Fault::new(origin, message);
    let (path, value) = text
        .split_once('=')
        .ok_or_else(|| refuse("has no `=`; write PATH=VALUE, as in time.frames=10".to_owned()))?;
    let path = path.trim();
    let steps = steps(path).ok_or_else(|| {
        refuse(format!("`{path}` is not a path; write keys, names and indices with dots: body.flag.mass"))
    })?;
    if steps.len() > DEEPEST {
        return Err(refuse(format!("has {} steps, {DEEPEST} are the most that a scene has", steps.len())));
    }
    let mut node = root;
    let mut done = String::new();
    for step in &steps {
        node = enter(node, &done, step, origin).map_err(refuse)?;
        let dot = if done.is_empty() { "" } else { "." };
        done.push_str(&format!("{dot}{step}"));
    }
    *node = parse_set_value(value.trim(), path, index)?;
    Ok(())
}

/// The steps of `body.flag.x`, `body[0].x`, `body."a.b".x`.
fn steps(path: &str) -> Option<Vec<String>> {
    let mut steps = Vec::new();
    let mut rest = path;
    while !rest.is_empty() {
        let (step, after) = if let Some(quoted) = rest.strip_prefix('"') {
            quoted.split_once('"')?
        } else if let Some(index) = rest.strip_prefix('[') {
            index.split_once(']')?
        } else {
            rest.split_at(rest.find(['.', '[']).unwrap_or(rest.len()))
        };
        if step.is_empty() {
            return None;
        }
        steps.push(step.to_owned());
        rest = match after.strip_prefix('.') {
            Some("") => return None,
            Some(next) => next,
            None if after.is_empty() || after.starts_with('[') => after,
            None => return None,
        };
    }
    (!steps.is_empty()).then_some(steps)
}

/// The value at `step` of `node`; a key that a table does not have is made, and refused later if it may not be there.
fn enter<'n>(node: &'n mut Node, done: &str, step: &str, origin: Origin) -> Result<&'n mut Node, String> {
    let found = node.to_string();
    match &mut node.value {
        Value::Table(entries) => {
            let position = entries.iter().position(|entry| entry.key == step).unwrap_or_else(|| {
                let node = Node { origin, value: Value::Table(Vec::new()) };
                entries.push(Entry { key: step.to_owned(), key_origin: origin, node });
                entries.len() - 1
            });
            Ok(&mut entries[position].node)
        }
        Value::List(items) => {
            let position = element(items, done, step)?;
            Ok(&mut items[position])
        }
        _ => Err(format!("`{done}` is {found}: it has no `{step}`")),
    }
}

/// Index of the element called `step`.
fn element(items: &[Node], list: &str, step: &str) -> Result<usize, String> {
    let names: Vec<String> = items
        .iter()
        .enumerate()
        .map(|(i, item)| name_of(item).unwrap_or_else(|| format!("{list}{i}")))
        .collect();
    if let Some(position) = names.iter().position(|name| name == step) {
        return Ok(position);
    }
    match step.parse::<usize>() {
        Ok(index) if index < items.len() => Ok(index),
        Ok(index) => Err(format!("`{list}` has no element {index}; it has {}, counted from 0", items.len())),
        Err(_) => {
            let valid: Vec<&str> = names.iter().map(String::as_str).collect();
            Err(format!("no `{list}` is called `{step}`{}", nearest_of(step, &valid)))
        }
    }
}

fn name_of(item: &Node) -> Option<String> {
    let Value::Table(entries) = &item.value else { return None };
    entries.iter().find(|entry| entry.key == "name").and_then(|entry| match &entry.node.value {
        Value::Text(name) if !name.is_empty() => Some(name.clone()),
        _ => None,
    })
}
