//! Where a value stands: keys and indices from the outside in.

use std::fmt;
use std::ops::Deref;

/// The path of a field in what was handed in, written `recipe.handles[2].count`. It reads as a text, and is taken apart
/// by whole keys: `handle` is no beginning of `handles[2]`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct FieldPath(String);

impl FieldPath {
    /// The field seen from outside `outer`, which holds it.
    pub fn within(self, outer: &str) -> Self {
        match (outer.is_empty(), self.0.is_empty()) {
            (true, _) => self,
            (_, true) => Self(outer.into()),
            _ if self.0.starts_with('[') => Self(format!("{outer}{}", self.0)),
            _ => Self(format!("{outer}.{}", self.0)),
        }
    }

    /// The field seen from inside `outer`, if it stands there.
    pub fn inside(&self, outer: &str) -> Option<Self> {
        let rest = self.0.strip_prefix(outer)?;
        match rest.as_bytes().first() {
            None | Some(b'[') => Some(Self(rest.into())),
            Some(b'.') => Some(Self(rest[1..].into())),
            Some(_) => None,
        }
    }
}

impl Deref for FieldPath {
    type Target = str;

    fn deref(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for FieldPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl From<&str> for FieldPath {
    fn from(path: &str) -> Self {
        Self(path.into())
    }
}

impl From<String> for FieldPath {
    fn from(path: String) -> Self {
        Self(path)
    }
}

impl From<&String> for FieldPath {
    fn from(path: &String) -> Self {
        Self(path.clone())
    }
}

impl From<FieldPath> for String {
    fn from(path: FieldPath) -> Self {
        path.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_taken_apart_by_whole_keys() {
        let path = FieldPath::from("handles[2].count").within("recipe");
        assert_eq!(&*path, "recipe.handles[2].count");
        assert_eq!(&*path.inside("recipe").unwrap(), "handles[2].count");
        assert_eq!(&*path.inside("recipe.handles").unwrap(), "[2].count");
        assert_eq!(
            path.inside("recipe.handles")
                .unwrap()
                .within("regions")
                .to_string(),
            "regions[2].count"
        );
        assert_eq!(path.inside("recipe.handle"), None);
        assert_eq!(path.inside("avatar"), None);
        assert_eq!(&*FieldPath::from("").within("recipe"), "recipe");
    }
}
