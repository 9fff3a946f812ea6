//! Pictures, GLB and reports out.
