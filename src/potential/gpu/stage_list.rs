//! The one list of stages.

/// Hands `name: Type,` of every stage, in the order in which the data flows, to the macro `$then`.
///
/// Stage `name` is `kernels/name.wgsl`, its twin `cpu/name.rs`, and its host side `name.rs` beside this file, where
/// `Type` implements [`Stage`](super::stage::Stage). Texts, pipelines and timings all follow from the line here.
macro_rules! with_stages {
    ($then:ident) => {
        $then! {
            pose_blend: PoseBlend,
            displacement: Displacement,
            inertial_target: InertialTarget,
            elasticity: Elasticity,
            contact: Contact,
            select: Select,
            friction: Friction,
            compact: Compact,
            gradient: Gradient,
            point_hessian: PointHessian,
            hessian: Hessian,
            energy: Energy,
            skin: Skin,
            normals: Normals,
        }
    };
}
pub(super) use with_stages;
