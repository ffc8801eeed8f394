//! Settings that change nothing: those of a solver that is not chosen, and struts without a number.

use super::document::{Entry, Node, Value};

/// Takes them out of a scene, where nothing reads them, and says so.
pub(super) fn set_aside(root: &mut Node) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some(solver) = table(root, "solver") {
        let method = solver.iter().find(|entry| entry.key == "method").map(|entry| &entry.node.value);
        let unused: &[&str] = match method {
            None => &["ice", "acad", "xpbd"],
            Some(Value::Text(name)) => match name.as_str() {
                "springs" => &["ice", "acad", "xpbd"],
                "ice" => &["acad", "xpbd"],
                // Of "ice" it has tolerance and iterations.
                "acad" => &["xpbd"],
                "xpbd" => &["ice", "acad"],
                _ => &[],
            },
            Some(_) => &[],
        };
        let method = match method {
            Some(Value::Text(name)) => name.clone(),
            _ => "springs".to_owned(),
        };
        solver.retain(|entry| {
            let unused = unused.contains(&entry.key.as_str());
            if unused {
                notes.push(format!("`solver.{}` is not used by the method \"{method}\"", entry.key));
            }
            !unused
        });
    }
    if let Value::Table(entries) = &mut root.value
        && let Some(Entry { node: Node { value: Value::List(bodies), .. }, .. }) =
            entries.iter_mut().find(|entry| entry.key == "body")
    {
        for (index, body) in bodies.iter_mut().enumerate() {
            if has_uncounted_struts(body) {
                notes.push(format!(
                    "`body[{index}].springs.internal` makes no struts: it has neither count nor file"
                ));
            }
        }
    }
    notes
}

fn has_uncounted_struts(body: &mut Node) -> bool {
    let springs =
        table(body, "springs").and_then(|keys| keys.iter_mut().find(|entry| entry.key == "internal"));
    let Some(Entry { node: Node { value: Value::Table(keys), .. }, .. }) = springs else { return false };
    !keys.iter().any(|entry| ["count", "file"].contains(&entry.key.as_str()))
}

fn table<'a>(root: &'a mut Node, key: &str) -> Option<&'a mut Vec<Entry>> {
    let Value::Table(entries) = &mut root.value else { return None };
    match entries.iter_mut().find(|entry| entry.key == key) {
        Some(Entry { node: Node { value: Value::Table(inner), .. }, .. }) => Some(inner),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse_scene;

    #[test]
    fn settings_of_a_solver_that_is_not_chosen_are_set_aside() {
        let ice = "[solver.ice]\ntolerance = 1e-3\n[[body]]\nmass = 1.0\nmesh.chain = { links = 2, length = 1.0 }\n";
        let loaded = parse_scene(ice, "s.toml", &[]).unwrap();
        assert!(loaded.notes[0].contains("`solver.ice` is not used"));
        assert_eq!(loaded.scene.solver.ice.tolerance, 1e-3);
        let chosen =
            format!("[solver]\nmethod = \"ice\"\nacad.threshold = 0.2\n{ice}").replace("1e-3", "1e-5");
        let loaded = parse_scene(&chosen, "s.toml", &[]).unwrap();
        assert_eq!(loaded.notes, ["`solver.acad` is not used by the method \"ice\""]);
        assert_eq!(loaded.scene.solver.ice.tolerance, 1e-5);
    }

    #[test]
    fn struts_without_a_number_are_said_to_be_none() {
        let notes = |internal: &str| {
            let scene =
                format!("[[body]]\nmass = 1.0\nmesh.cube = {{ size = 1.0, divisions = 1 }}\n{internal}");
            parse_scene(&scene, "s.toml", &[]).unwrap().notes
        };
        assert_eq!(
            notes("springs.internal = { k = 1.0 }"),
            ["`body[0].springs.internal` makes no struts: it has neither count nor file"]
        );
        assert!(notes("springs.internal = { count = 0, k = 1.0 }").is_empty());
        assert!(notes("springs.internal = { file = \"s.txt\", k = 1.0 }").is_empty());
    }
}
