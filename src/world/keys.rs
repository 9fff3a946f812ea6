//! What a world calls its things by.

slotmap::new_key_type! {
    /// An avatar that was handed to a world, of which it makes instances.
    pub struct AvatarId;
    /// One avatar that stands in a world.
    pub struct InstanceId;
    /// A rigid body of a world.
    pub struct BodyId;
    /// A collider of a world.
    pub struct ColliderId;
}
