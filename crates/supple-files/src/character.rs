//! Any character file: what it is, and the body in it.

use super::{
    PartNames, SmplModel, parse_gltf, parse_obj, parse_smpl, parse_tets, read_betas, read_gltf,
    read_obj, read_smpl_model, read_tets, separate_tissue,
};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use supple::internal::math::Rows;
use supple::model::{JointList, PoseBlend, Skeleton, SkinWeight, Surface, UpAxis};
use supple::{Error, Result};
use supple_bake::{Body, LayerMesh};

/// What a character file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CharacterFormat {
    /// SMPL, SMPL-H, SMPL-X or MANO: `.npz`, `.pkl`.
    Smpl,
    /// `.glb`, `.gltf`, `.vrm`.
    Gltf,
    /// A skin around one bone: `.obj`.
    Obj,
    /// Tets ([`read_tets`]): `.node` and `.ele`, `.msh`, `.mesh`, `.meshb`, and plain text.
    Tets,
}

/// What a file is, judged by its first bytes and its extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A character to be baked.
    Character(CharacterFormat),
    /// A recipe or a scene.
    Toml,
    /// A baked avatar.
    Baked,
}

/// What can be read, for messages.
const KNOWN: &str = "known are .npz and .pkl (SMPL, SMPL-H, SMPL-X, MANO), .glb, .gltf and .vrm, .obj (a skin around one \
                     bone), .node/.ele, .msh and .mesh (tets), .toml (a recipe or a scene)";

impl FileKind {
    /// The kind of the file at `path`.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Format`] of anything else, with what can be read.
    pub fn of(path: &Path) -> Result<Self> {
        let mut start = [0; 64];
        let mut length = 0;
        let mut file = File::open(path).map_err(|e| Error::io(path, e))?;
        loop {
            match file.read(&mut start[length..]) {
                Ok(0) => break,
                Ok(read) => length += read,
                Err(e) => return Err(Error::io(path, e)),
            }
        }
        Self::of_bytes(&start[..length], path)
    }

    /// The kind of a file whose `bytes`, or the first 64 of them, are in memory; `path` names it.
    ///
    /// # Errors
    /// [`Error::Format`] of what is none of these, with what can be read.
    pub fn of_bytes(bytes: &[u8], path: &Path) -> Result<Self> {
        if bytes.is_empty() {
            return Err(Error::format(path, "format", "is empty"));
        }
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        Self::from_start(&bytes[..bytes.len().min(64)], &extension.to_lowercase())
            .map_err(|problem| Error::format(path, "format", problem))
    }

    /// By content where that is plain, else by extension.
    fn from_start(start: &[u8], extension: &str) -> Result<Self, String> {
        use CharacterFormat::{Gltf, Obj, Smpl, Tets};
        const PICKLE: u8 = 0x80;
        let text = String::from_utf8_lossy(start);
        let begins = |word: &str| text.trim_start().starts_with(word);
        Ok(match extension {
            _ if start.starts_with(b"SUPPLE\r\n") => Self::Baked,
            _ if start.starts_with(b"glTF") => Self::Character(Gltf),
            _ if start.starts_with(b"PK\x03\x04") => Self::Character(Smpl),
            _ if start.first() == Some(&PICKLE) => Self::Character(Smpl),
            _ if begins("$MeshFormat") || begins("MeshVersionFormatted") => Self::Character(Tets),
            "npz" | "pkl" | "pickle" => Self::Character(Smpl),
            "glb" | "gltf" | "vrm" | "vrma" => Self::Character(Gltf),
            "obj" => Self::Character(Obj),
            "node" | "ele" | "face" | "msh" | "mesh" | "meshb" | "txt" => Self::Character(Tets),
            "toml" => Self::Toml,
            "supple" => return Err("is no baked avatar, or was cut short: bake it again".into()),
            "bvh" | "jsonl" | "js" => {
                let problem = "is a motion, and a character is needed: name the motion in a scene";
                return Err(problem.into());
            }
            "" => return Err(format!("has no extension and is not recognised; {KNOWN}")),
            other => return Err(format!("a .{other} file cannot be read; {KNOWN}")),
        })
    }
}

/// What a character file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct CharacterFile {
    /// What the file is.
    pub format: CharacterFormat,
    /// The body; its layer is meshed only where the file holds tets.
    pub body: Body,
    /// The file's own vertex that each skin vertex is; none for a glTF file, whose seams are welded.
    pub file_vertices: Vec<u32>,
    /// Vertices in the file, for the kinds that have `file_vertices`.
    pub file_vertex_count: usize,
    /// Names of its shape directions, in order.
    pub shapes: Vec<String>,
    /// What was decided about the file, a sentence each.
    pub notes: Vec<String>,
}

/// What is asked of a character file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CharacterOptions {
    /// Amounts of its shapes, in order; missing ones are 0, or the file's own default.
    pub betas: Vec<f64>,
    /// A motion of AMASS whose person's shape an SMPL model takes, in place of `betas`: the first as many as it has.
    pub betas_of: Option<PathBuf>,
    /// Bones that regions of tets are, by the file's labels.
    pub regions: BTreeMap<String, String>,
    /// Parts that are tissue or rigid, against what is chosen.
    pub parts: PartNames,
}

/// Reads the character file at `path`.
///
/// # Errors
/// [`Error::Io`], [`Error::Format`] with the key or line at fault and its cure.
pub fn read_character(path: impl AsRef<Path>, options: &CharacterOptions) -> Result<CharacterFile> {
    let path = path.as_ref();
    character(path, None, FileKind::of(path)?, options)
}

/// [`read_character`] of a file's `bytes`; `path` names it, and other files that it asks for lie relative to it.
///
/// # Errors
/// As [`read_character`].
pub fn parse_character(
    bytes: &[u8],
    path: impl AsRef<Path>,
    options: &CharacterOptions,
) -> Result<CharacterFile> {
    let path = path.as_ref();
    character(path, Some(bytes), FileKind::of_bytes(bytes, path)?, options)
}

/// The character of `bytes`, or else of the file at `path`.
fn character(
    path: &Path,
    bytes: Option<&[u8]>,
    kind: FileKind,
    options: &CharacterOptions,
) -> Result<CharacterFile> {
    let betas = &options.betas;
    let format = match kind {
        FileKind::Character(format) => format,
        FileKind::Toml => {
            let problem = "is a recipe or a scene, and a character file is needed";
            return Err(Error::format(path, "format", problem));
        }
        FileKind::Baked => return Err(Error::format(path, "format", "is baked already")),
    };
    let check_betas = |known: usize| check_shape(betas, known).map_err(|e| e.of_file(path));
    if options.betas_of.is_some() && format != CharacterFormat::Smpl {
        let problem =
            "the shape of a motion's person is for SMPL's models: give `betas` of this file's own";
        return Err(Error::format(path, "betas_of", problem));
    }
    let mut file = CharacterFile {
        format,
        body: skin_around_one_bone("", Vec::new()),
        file_vertices: Vec::new(),
        file_vertex_count: 0,
        shapes: Vec::new(),
        notes: Vec::new(),
    };
    let name = stem(path);
    let of_file = |e: Error| e.of_file(path);
    match format {
        CharacterFormat::Smpl => {
            let model = match bytes {
                Some(bytes) => parse_smpl(bytes, path)?,
                None => read_smpl_model(path)?,
            };
            let shapes = model.shapes;
            let mut betas = betas.clone();
            let mut notes = Vec::new();
            if let Some(motion) = &options.betas_of {
                betas = read_betas(motion)?;
                let (given, used) = (betas.len(), betas.len().min(shapes));
                betas.truncate(used);
                let motion = motion.display();
                notes.push(format!(
                    "its shape is that of {motion}: {used} of {given} betas"
                ));
            }
            file =
                CharacterFile::of_model(&name, model, &betas, &options.parts).map_err(of_file)?;
            file.notes.splice(0..0, notes);
        }
        CharacterFormat::Gltf => {
            let character = match bytes {
                Some(bytes) => parse_gltf(bytes, path)?,
                None => read_gltf(path)?,
            };
            check_betas(character.shapes().len())?;
            file.body = (character.body_of_parts(betas, &options.parts)).map_err(of_file)?;
            file.shapes = character.shapes().iter().map(|s| s.name.clone()).collect();
            file.notes = character.notes;
        }
        CharacterFormat::Obj => {
            check_betas(0)?;
            let objects = match bytes {
                Some(bytes) => parse_obj(bytes, path)?,
                None => read_obj(path)?,
            };
            file.body = skin_around_one_bone(&name, objects);
            file.separate(&options.parts).map_err(of_file)?;
        }
        CharacterFormat::Tets => {
            check_betas(0)?;
            if !options.parts.is_empty() {
                let problem = "tets are one part: leave `tissue` and `rigid` out";
                return Err(Error::format(path, "tissue", problem));
            }
            let tets = match bytes {
                Some(bytes) => parse_tets(bytes, path)?,
                None => read_tets(path)?,
            };
            let body = tets.body(&name, &options.regions);
            file.body = body.map_err(of_file)?;
            let vertices = file.body.skin.positions.len();
            file.file_vertex_count = vertices;
            file.file_vertices = (0..vertices as u32).collect();
        }
    }
    if format != CharacterFormat::Smpl {
        file.note_tissue();
    }
    Ok(file)
}

/// Whether a model of `known` shapes takes these amounts.
fn check_shape(betas: &[f64], known: usize) -> Result<()> {
    if let Some(k) = betas.iter().position(|b| !b.is_finite()) {
        let problem = format!("must be a finite number, is {}", betas[k]);
        return Err(Error::invalid(format!("shape[{k}]"), problem));
    }
    if betas.len() > known {
        let given = betas.len();
        let problem = format!("{given} numbers are given; the model has {known} shapes");
        return Err(Error::invalid("shape", problem));
    }
    Ok(())
}

impl CharacterFile {
    /// A model of SMPL's kind in the shape `betas`, of a file or of a program's arrays.
    pub(crate) fn of_model(
        name: &str,
        model: SmplModel,
        betas: &[f64],
        parts: &PartNames,
    ) -> Result<Self> {
        let SmplModel {
            model,
            shapes,
            file_order,
            ..
        } = model;
        let directions = model.shape_directions.len();
        check_shape(betas, directions)?;
        let called = |k: usize| match k.checked_sub(shapes) {
            None => format!("shape {k}"),
            Some(k) => format!("expression {k}"),
        };
        let mut body = Body::of_model(name, &model, betas, Vec::new());
        body.joints = JointList::of_bones_in_order(&body.skeleton, &file_order);
        let mut file = Self {
            format: CharacterFormat::Smpl,
            body,
            file_vertices: Vec::new(),
            file_vertex_count: 0,
            shapes: (0..directions).map(called).collect(),
            notes: Vec::new(),
        };
        file.separate(parts)?;
        file.note_tissue();
        Ok(file)
    }

    /// Says what is tissue, where that was chosen.
    fn note_tissue(&mut self) {
        let tissue = self.body.tissue_parts();
        if tissue.len() > 1 || !self.body.attachments.is_empty() && !tissue.is_empty() {
            let note = format!("tissue is {}", tissue.join(", "));
            self.notes.push(note);
        }
    }

    /// Attaches what is not tissue, and keeps account of the file's vertices.
    fn separate(&mut self, named: &PartNames) -> Result<()> {
        /// A map that goes through the separation and is taken out again.
        const VERTEX: &str = "vertex of the file";
        let whole = &mut self.body;
        self.file_vertex_count = whole.skin.positions.len();
        let numbers = (0..self.file_vertex_count).map(|v| v as f64).collect();
        whole.painted.insert(VERTEX.into(), numbers);
        self.body = separate_tissue(whole.clone(), named)?;
        let numbers = self.body.painted.remove(VERTEX).unwrap_or_default();
        self.file_vertices = numbers.into_iter().map(|v| v as u32).collect();
        Ok(())
    }

    /// Paints `map`, a number for each of the file's vertices, on the skin.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the numbers are not as many as the file's vertices, or the file is a glTF file: paint a
    /// vertex attribute there.
    pub fn paint(&mut self, name: &str, map: &[f64]) -> Result<()> {
        if self.file_vertices.is_empty() {
            let problem = "vertices of a glTF file are welded: paint a scalar vertex attribute `_NAME` or a colour \
                           in the file itself";
            return Err(Error::invalid(format!("painted.{name}"), problem));
        }
        if map.len() != self.file_vertex_count {
            let (found, expected) = (map.len(), self.file_vertex_count);
            let problem =
                format!("holds {found} numbers; the character file has {expected} vertices");
            return Err(Error::invalid(format!("painted.{name}"), problem));
        }
        let values = self.file_vertices.iter().map(|&v| map[v as usize]);
        self.body.painted.insert(name.into(), values.collect());
        Ok(())
    }
}

/// All surfaces of `objects` around one bone in their middle.
fn skin_around_one_bone(name: &str, objects: Vec<(String, Surface)>) -> Body {
    let mut skin = Surface::default();
    for (_, part) in objects {
        let first = skin.positions.len() as u32;
        skin.positions.extend(part.positions);
        let shifted = part.triangles.into_iter().map(|t| t.map(|v| v + first));
        skin.triangles.extend(shifted);
    }
    let (low, high) = skin.bounds();
    let whole = SkinWeight {
        bone: 0,
        weight: 1.0,
    };
    let skeleton = Skeleton {
        names: vec!["bone".into()],
        parents: vec![None],
        joints: vec![0.5 * (low + high)],
        aliases: Vec::new(),
        limits: Vec::new(),
    };
    Body {
        name: name.into(),
        joints: JointList::of_bones(&skeleton),
        springs: Default::default(),
        up: UpAxis::Z,
        skeleton,
        skinning: skin.positions.iter().map(|_| [whole]).collect::<Rows<_>>(),
        skin,
        pose_blend: PoseBlend::default(),
        bone_surfaces: Vec::new(),
        layer: LayerMesh::default(),
        painted: Default::default(),
        attachments: Vec::new(),
        render_meshes: Vec::new(),
        appearance: Default::default(),
    }
}

/// File name without folder and extension.
fn stem(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_told_by_content_before_extension() {
        use CharacterFormat::{Gltf, Smpl, Tets};
        let kind = |start: &[u8], extension: &str| FileKind::from_start(start, extension);
        let character = |format| Ok(FileKind::Character(format));
        assert_eq!(kind(b"glTF\x02\0\0\0", "bin"), character(Gltf));
        assert_eq!(kind(b"PK\x03\x04..", ""), character(Smpl));
        assert_eq!(kind(b"\x80\x04\x95", "model"), character(Smpl));
        assert_eq!(kind(b"{\"asset\"", "gltf"), character(Gltf));
        assert_eq!(kind(b"\n$MeshFormat\n4.1", "txt"), character(Tets));
        assert_eq!(kind(b"SUPPLE\r\n\x02", "glb"), Ok(FileKind::Baked));
        assert_eq!(kind(b"model = ", "toml"), Ok(FileKind::Toml));
        for (extension, hint) in [("bvh", "motion"), ("fbx", ".glb"), ("", "no extension")] {
            let problem = kind(b"????", extension).unwrap_err();
            assert!(problem.contains(hint), "{problem}");
        }
    }

    #[test]
    fn bytes_are_read_as_the_file_is() {
        let folder = tempfile::tempdir().unwrap();
        let obj =
            "o solid\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
        let tets = "MeshVersionFormatted 2\nDimension 3\nVertices 5\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0.2 0.2 0.2 0\n\
                    Tetrahedra 4\n1 2 3 5 0\n1 4 2 5 0\n1 3 4 5 0\n2 4 3 5 0\nEnd\n";
        let broken = "{\"asset\": {\"version\": \"2.0\"}}";
        let options = CharacterOptions::default();
        for (name, text) in [
            ("a.obj", obj),
            ("a.mesh", tets),
            ("a.gltf", broken),
            ("a.npz", "PK"),
            ("a.fbx", "?"),
            ("a.glb", ""),
        ] {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            let of_file = read_character(&path, &options);
            let of_bytes = parse_character(text.as_bytes(), &path, &options);
            match (of_file, of_bytes) {
                (Ok(file), Ok(bytes)) => assert_eq!(file, bytes, "{name}"),
                (Err(file), Err(bytes)) => assert_eq!(file.to_string(), bytes.to_string()),
                (file, bytes) => panic!("{name}: {file:?} and {bytes:?}"),
            }
        }
        let known = |name: &str, text: &str| parse_character(text.as_bytes(), name, &options);
        assert!(known("a.obj", obj).is_ok() && known("a.mesh", tets).is_ok());
        assert!(known("a.gltf", broken).is_err());
    }
}
