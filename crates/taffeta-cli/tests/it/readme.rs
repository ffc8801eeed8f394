//! What the README shows is there.

const README: &str = include_str!("../../../../README.md");

#[test]
fn the_cloth_of_the_readme_is_the_example_of_that_name() {
    let example = include_str!("../../../taffeta/examples/first_cloth.rs");
    let shown = README.split("```rust\n").nth(1).and_then(|rest| rest.split("```").next());
    // The example has a line of its own on top, for who finds it without the page.
    let code = example.split_once("\n\n").map(|(_, code)| code);
    assert!(shown.is_some() && shown == code, "README.md and crates/taffeta/examples/first_cloth.rs differ");
}
