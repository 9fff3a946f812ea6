//! Every pipeline of the scene, made once.

use super::gpu::Gpu;
use super::texture::{DEPTH, SAMPLES};
use supple::wgpu;
use wgpu::ShaderStages as Stages;

/// Layouts of bind groups, and the pipelines over them.
pub struct Pipelines {
    /// The view alone, for shadows.
    pub view_layout: wgpu::BindGroupLayout,
    /// The view and what the sun sees.
    pub frame_layout: wgpu::BindGroupLayout,
    /// A posed skin and the colours shown on it.
    pub skin_layout: wgpu::BindGroupLayout,
    /// A part of a character's file.
    pub part_layout: wgpu::BindGroupLayout,
    pub skin: wgpu::RenderPipeline,
    pub solid: wgpu::RenderPipeline,
    pub overlay: wgpu::RenderPipeline,
    pub skin_shadow: wgpu::RenderPipeline,
    pub solid_shadow: wgpu::RenderPipeline,
}

/// A mesh's vertex: position and normal.
const MESH: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: 24,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
};

/// Where a mesh stands: three rows of a matrix, and a colour.
const INSTANCE: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: 64,
    step_mode: wgpu::VertexStepMode::Instance,
    attributes: &wgpu::vertex_attr_array![
        2 => Float32x4, 3 => Float32x4, 4 => Float32x4, 5 => Float32x4
    ],
};

impl Pipelines {
    /// For pictures in `format`.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let device = &gpu.device;
        let shader = device.create_shader_module(wgpu::include_wgsl!("scene.wgsl"));
        let view = (Stages::VERTEX_FRAGMENT, uniform());
        let depths = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Depth,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let compare = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison);
        let filtering = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let picture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let (vertex, fragment) = (Stages::VERTEX, Stages::FRAGMENT);
        let view_layout = layout(device, &[view]);
        let frame_layout = layout(device, &[view, (fragment, depths), (fragment, compare)]);
        let skin_layout = layout(device, &[(vertex, storage()), (vertex, storage())]);
        let part_layout = layout(
            device,
            &[
                (vertex, storage()),
                (fragment, uniform()),
                (fragment, picture),
                (fragment, picture),
                (fragment, filtering),
            ],
        );
        let with_skin = |first| pipeline_layout(device, &[first, &skin_layout, &part_layout]);
        let alone = |first| pipeline_layout(device, &[first]);
        let make = |layout: &wgpu::PipelineLayout, vertex: &str, fragment, compare| {
            let look = Look {
                vertex,
                fragment,
                compare,
            };
            pipeline(device, &shader, layout, &look, format)
        };
        let (less, always) = (wgpu::CompareFunction::Less, wgpu::CompareFunction::Always);
        let (skins, skin_shadows) = (with_skin(&frame_layout), with_skin(&view_layout));
        let (solids, solid_shadows) = (alone(&frame_layout), alone(&view_layout));
        Self {
            skin: make(&skins, "skin_vertex", Some("skin_colour"), less),
            solid: make(&solids, "solid_vertex", Some("solid_colour"), less),
            overlay: make(&solids, "solid_vertex", Some("overlay_colour"), always),
            skin_shadow: make(&skin_shadows, "skin_shadow", None, less),
            solid_shadow: make(&solid_shadows, "solid_shadow", None, less),
            view_layout,
            frame_layout,
            skin_layout,
            part_layout,
        }
    }
}

fn uniform() -> wgpu::BindingType {
    buffer(wgpu::BufferBindingType::Uniform)
}

fn storage() -> wgpu::BindingType {
    buffer(wgpu::BufferBindingType::Storage { read_only: true })
}

fn buffer(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}

/// A layout of these bindings in order.
pub fn layout(
    device: &wgpu::Device,
    bindings: &[(wgpu::ShaderStages, wgpu::BindingType)],
) -> wgpu::BindGroupLayout {
    let entry = |(binding, &(visibility, ty)): (u32, &_)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty,
        count: None,
    };
    let entries: Vec<_> = (0..).zip(bindings).map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    })
}

/// A layout of these groups in order.
pub fn pipeline_layout(
    device: &wgpu::Device,
    groups: &[&wgpu::BindGroupLayout],
) -> wgpu::PipelineLayout {
    let groups: Vec<_> = groups.iter().map(|group| Some(*group)).collect();
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &groups,
        immediate_size: 0,
    })
}

/// Entry points, and what is nearer.
struct Look<'a> {
    vertex: &'a str,
    /// None where only depths are wanted.
    fragment: Option<&'a str>,
    compare: wgpu::CompareFunction,
}

fn pipeline(
    device: &wgpu::Device,
    shader: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    look: &Look<'_>,
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let meshes = [Some(MESH), Some(INSTANCE)];
    let targets = [Some(format.into())];
    let shadow = look.fragment.is_none();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(look.vertex),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: shader,
            entry_point: Some(look.vertex),
            compilation_options: Default::default(),
            buffers: match look.vertex.starts_with("solid") {
                true => &meshes,
                false => &[],
            },
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(look.compare != wgpu::CompareFunction::Always),
            depth_compare: Some(look.compare),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState {
            count: if shadow { 1 } else { SAMPLES },
            ..Default::default()
        },
        fragment: look.fragment.map(|entry| wgpu::FragmentState {
            module: shader,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
