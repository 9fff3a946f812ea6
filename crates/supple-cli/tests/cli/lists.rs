//! What is listed: adapters.

use super::good;

#[test]
fn adapters_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let json = good(folder.path(), &["adapters", "--json"]);
    assert!(
        serde_json::from_str::<serde_json::Value>(&json)
            .unwrap()
            .is_array()
    );
    assert!(!good(folder.path(), &["adapters"]).is_empty());
}
