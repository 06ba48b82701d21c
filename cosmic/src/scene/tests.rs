//! What must hold between the structs, the table and the files.

use super::table::SECTIONS;
use super::*;

#[test]
fn the_table_names_exactly_the_fields_of_the_structs() {
    let scene = serde_json::to_value(Scene::default()).unwrap();
    let mut in_structs: Vec<String> = Vec::new();
    for (section, keys) in scene.as_object().unwrap() {
        in_structs.extend(
            keys.as_object()
                .unwrap()
                .keys()
                .map(|key| format!("{section}.{key}")),
        );
    }
    let mut in_table: Vec<String> = Vec::new();
    for section in SECTIONS {
        in_table.extend(
            section
                .fields
                .iter()
                .map(|field| format!("{}.{}", section.name, field.key)),
        );
    }
    in_structs.sort();
    in_table.sort();
    assert_eq!(in_structs, in_table);
}
