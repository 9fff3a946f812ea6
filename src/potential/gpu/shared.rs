//! The structs that the host shares with the kernels; `kernels/shared` has their twins, with what each
//! field means. A material's parameters are in its own file ([`crate::material`]).

use crate::gpu::{HostShareable, StructLayout, host_shareable};

/// A 3×3 matrix as kernels store it: columns, each padded to 16 bytes.
pub type Mat3 = [[f32; 4]; 3];

host_shareable! {
    /// What is constant for a set of points (kernels/shared/batch.wgsl).
    pub struct Constants {
        /// Points of the set.
        pub points: u32,
        /// Bones.
        pub bones: u32,
        /// Handles.
        pub handles: u32,
        /// Pose features of the set.
        pub features: u32,
        /// 3-vectors of q.
        pub blocks: u32,
        /// Stored blocks of the Hessian.
        pub pattern_blocks: u32,
        /// Σ of the blocks of every cubature point.
        pub local_blocks: u32,
        /// Σ of the pairs of blocks of every cubature point.
        pub local_pairs: u32,
        /// Room for colliders, an instance.
        pub colliders: u32,
        /// Room for active contacts, a state.
        pub contacts: u32,
        /// Most blocks that move one skin vertex.
        pub contact_blocks: u32,
        /// Workgroups over the cubature points.
        pub point_groups: u32,
        /// Workgroups over the skin.
        pub vertex_groups: u32,
        /// ρ, kg/m³.
        pub density: f32,
        /// From an instance's posed skin to the next one's, vertices.
        pub skin_stride: u32,
        /// Skin vertices that may have offsets, an instance.
        pub offset_vertices: u32,
    }

    /// One state of a batch (kernels/shared/batch.wgsl).
    pub struct BatchState {
        /// On the tissue's displacement, m/s².
        pub gravity: [f32; 3],
        /// 1/h̃², 1/s².
        pub mass_rate: f32,
        /// What β is multiplied by, 1/s: the factor on it over h̃.
        pub damping_rate: f32,
        /// Whose state it is.
        pub instance: u32,
        /// Where its numbers are.
        pub slot: u32,
        /// Slot of the state that the energy is measured from.
        pub base: u32,
        /// Colliders of the instance.
        pub colliders: u32,
        /// ε = ε_v h, m.
        pub smoothing: f32,
        /// Factor on the tissue's stiffness.
        pub stiffness: f32,
        /// 1 where the host gave offsets of the skin, else 0.
        pub has_offsets: u32,
        /// Times the share of muscle, what tension adds to the factor on the stiffness.
        pub tension: f32,
        /// Padding.
        pub _pad: [u32; 3],
    }

    /// Which states of a batch a dispatch takes (kernels/shared/batch.wgsl).
    pub struct Chunk {
        /// The first.
        pub first: u32,
    }

    /// A material point (kernels/shared/kinematics.wgsl).
    pub struct Point {
        /// X, m.
        pub position: [f32; 3],
        /// Cubature weight (m³) or area (m²).
        pub measure: f32,
        /// Its bones, then its handles, among the influences.
        pub first_influence: u32,
        /// Number of bones.
        pub bones: u32,
        /// Number of handles.
        pub handles: u32,
        /// Its handles among the gradients.
        pub first_gradient: u32,
        /// Its blocks among all points'.
        pub first_block: u32,
        /// Its pairs of blocks among all points'.
        pub first_pair: u32,
        /// What it follows of the skin's offsets, among the influences.
        pub first_share: u32,
        /// Number of skin vertices that it follows.
        pub shares: u32,
        /// Of a skin vertex: k of the tissue under it, Pa/m.
        pub contact_stiffness: f32,
        /// Padding.
        pub _pad: [u32; 3],
    }

    /// What the material has of its own at a cubature point (kernels/shared/tissue.wgsl).
    pub struct LocalTissue {
        /// G.
        pub axes: Mat3,
        /// Factor on the energy.
        pub stiffness: f32,
        /// β, s.
        pub damping_time: f32,
        /// Share of muscle.
        pub muscle: f32,
        /// Padding.
        pub _pad: u32,
    }

    /// The share of a bone, a handle or a skin vertex (kernels/shared/kinematics.wgsl).
    pub struct Influence {
        /// Bone, handle or skin vertex.
        pub index: u32,
        /// w, U or E.
        pub weight: f32,
    }

    /// ∇U of one handle at one point (kernels/shared/kinematics.wgsl).
    pub struct HandleGradient {
        /// ∇U, 1/m.
        pub gradient: [f32; 3],
        /// Handle.
        pub handle: u32,
    }

    /// A bone's frame in one state (kernels/shared/kinematics.wgsl).
    pub struct Frame {
        /// R.
        pub rotation: Mat3,
        /// R − R_base.
        pub rotation_increment: Mat3,
        /// c relative to the instance's origin, m.
        pub position: [f32; 3],
        /// Padding.
        pub _pad0: u32,
        /// c − c_base, m.
        pub position_increment: [f32; 3],
        /// Padding.
        pub _pad1: u32,
        /// J, m.
        pub joint: [f32; 3],
        /// Padding.
        pub _pad2: u32,
    }

    /// A handle in one state (kernels/shared/kinematics.wgsl).
    pub struct Handle {
        /// φ_base, m.
        pub displacement: [f32; 3],
        /// Padding.
        pub _pad0: u32,
        /// φ − φ_base, m.
        pub increment: [f32; 3],
        /// Padding.
        pub _pad1: u32,
    }

    /// What inertia takes from the past of a bone (kernels/shared/kinematics.wgsl).
    pub struct PastFrame {
        /// Σ_k c_k (R(qⁿ⁻ᵏ) − R(qⁿ)).
        pub turn: Mat3,
        /// R(qⁿ⁻¹).
        pub first: Mat3,
        /// R(qⁿ⁻²).
        pub second: Mat3,
        /// R(qⁿ⁻³).
        pub third: Mat3,
        /// Σ_k c_k (c(qⁿ⁻ᵏ) − c(qⁿ)), m.
        pub shift: [f32; 3],
        /// Padding.
        pub _pad: u32,
    }

    /// What inertia takes from the past of a handle (kernels/shared/kinematics.wgsl).
    pub struct PastHandle {
        /// c₁ (φⁿ⁻¹ − φⁿ), m.
        pub first: [f32; 3],
        /// Padding.
        pub _pad0: u32,
        /// c₂ (φⁿ⁻² − φⁿ), m.
        pub second: [f32; 3],
        /// Padding.
        pub _pad1: u32,
        /// c₃ (φⁿ⁻³ − φⁿ), m.
        pub third: [f32; 3],
        /// Padding.
        pub _pad2: u32,
    }

    /// What a cubature point did (kernels/shared/kinematics.wgsl).
    pub struct Motion {
        /// d = x(q) − x(q_base), m.
        pub displacement: [f32; 3],
        /// Padding.
        pub _pad0: u32,
        /// T, m.
        pub unposed: [f32; 3],
        /// Padding.
        pub _pad1: u32,
        /// B = Σ_j w_j R_j.
        pub blended: Mat3,
    }

    /// Blocks C_ij, i ≥ j, of a tangent (kernels/shared/tensor.wgsl).
    pub struct Tangent {
        /// ∂P₀/∂F₀, Pa.
        pub c00: Mat3,
        /// ∂P₁/∂F₀, Pa.
        pub c10: Mat3,
        /// ∂P₁/∂F₁, Pa.
        pub c11: Mat3,
        /// ∂P₂/∂F₀, Pa.
        pub c20: Mat3,
        /// ∂P₂/∂F₁, Pa.
        pub c21: Mat3,
        /// ∂P₂/∂F₂, Pa.
        pub c22: Mat3,
    }

    /// A collider at the end of the step (kernels/shared/contact.wgsl).
    pub struct Collider {
        /// Rotation of its frame.
        pub rotation: Mat3,
        /// Origin of its frame relative to the instance's origin, m.
        pub position: [f32; 3],
        /// k, Pa/m.
        pub stiffness: f32,
        /// Sizes of the shape.
        pub parameters: [f32; 4],
        /// d̂, m.
        pub margin: f32,
        /// Number of the shape.
        pub shape: u32,
        /// μ.
        pub friction: f32,
        /// 1 + the frame that carries it, 0 where its motion is given.
        pub body: u32,
        /// R − Rⁿ, where its motion is given.
        pub rotation_change: Mat3,
        /// c − cⁿ, m, where its motion is given.
        pub position_change: [f32; 3],
        /// Padding.
        pub _pad: u32,
    }

    /// One direction in which a contact acts (kernels/shared/contact.wgsl).
    pub struct Contact {
        /// e, a unit vector.
        pub direction: [f32; 3],
        /// f, N.
        pub force: f32,
        /// k, N/m.
        pub stiffness: f32,
        /// Skin vertex.
        pub vertex: u32,
        /// 1 + the frame that carries the collider, 0 where its motion is given.
        pub body: u32,
        /// Padding.
        pub _pad: u32,
    }

    /// A contact of qⁿ with a rough collider (kernels/shared/friction.wgsl).
    pub struct Lagged {
        /// a, m.
        pub anchor: [f32; 3],
        /// μ λ, N.
        pub limit: f32,
        /// n.
        pub normal: [f32; 3],
        /// Skin vertex.
        pub vertex: u32,
        /// u at qⁿ, m.
        pub start: [f32; 3],
        /// As a collider's.
        pub body: u32,
        /// Collider of the instance.
        pub collider: u32,
        /// Padding.
        pub _pad: [u32; 3],
    }

    /// Some of the terms of a stored block of the Hessian (kernels/hessian.wgsl).
    pub struct HessianSegment {
        /// Which stored block.
        pub block: u32,
        /// Block row.
        pub row: u32,
        /// Block column.
        pub column: u32,
        /// Its first term.
        pub first: u32,
        /// The end of its terms.
        pub end: u32,
        /// Segments of the block, of its first one; 0 of the others, and of those that only fill up a workgroup.
        pub count: u32,
    }

    /// Energies, J, and the contact force, N (kernels/energy.wgsl).
    pub struct PartialEnergy {
        /// Σ m/(2h̃²) |x − x̂|².
        pub inertia: f32,
        /// −Σ m g · x.
        pub gravity: f32,
        /// Σ w Ψ(F).
        pub elastic: f32,
        /// Σ w β/(2h̃) (F − F̃) : Cⁿ : (F − F̃).
        pub damping: f32,
        /// Of the contacts on the skin.
        pub force: [f32; 3],
        /// Σ ½ k a δ².
        pub contact: f32,
        /// Σ μ λ f₀(|u_T|).
        pub friction: f32,
        /// Contacts for which there was no room.
        pub left_out: f32,
        /// Of contacts, what a quadratic model at the base does not foresee.
        pub unforeseen: f32,
        /// Σ k a δ.
        pub pressing: f32,
    }

    /// What is read back of every state (kernels/energy.wgsl).
    pub struct Summary {
        /// The sums.
        pub energy: PartialEnergy,
        /// Active contacts.
        pub contacts: u32,
        /// Contacts of the step's start that have friction.
        pub lagged: u32,
        /// Padding.
        pub _pad: [u32; 2],
    }

    /// A vertex of the posed skin (kernels/skin.wgsl).
    pub struct SkinVertex {
        /// Relative to the instance's origin, m.
        pub position: [f32; 3],
        /// Padding.
        pub _pad0: u32,
        /// Unit normal.
        pub normal: [f32; 3],
        /// Padding.
        pub _pad1: u32,
    }
}

/// Layout of every struct that is shared with the kernels whatever the material.
pub const SHARED_STRUCTS: &[StructLayout<'static>] = &[
    Constants::LAYOUT,
    BatchState::LAYOUT,
    Chunk::LAYOUT,
    Point::LAYOUT,
    LocalTissue::LAYOUT,
    Influence::LAYOUT,
    HandleGradient::LAYOUT,
    Frame::LAYOUT,
    Handle::LAYOUT,
    PastFrame::LAYOUT,
    PastHandle::LAYOUT,
    Motion::LAYOUT,
    Tangent::LAYOUT,
    Collider::LAYOUT,
    Contact::LAYOUT,
    Lagged::LAYOUT,
    HessianSegment::LAYOUT,
    PartialEnergy::LAYOUT,
    Summary::LAYOUT,
    SkinVertex::LAYOUT,
];
