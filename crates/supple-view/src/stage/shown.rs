//! The skin as it is shown: where it is, and the values that colour it.

use crate::bake::Character;
use glam::DVec3;
use supple_pictures::colour_map;

/// Which values colour the skin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ValueMap {
    /// None: it is painted as its file says.
    #[default]
    None,
    /// How far its tissue is off the skinned shape, m.
    Displacement,
    /// Of contact, Pa.
    Pressure,
    /// Of the tissue under it, m.
    Depth,
}

impl ValueMap {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::None, Self::Displacement, Self::Pressure, Self::Depth];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "as painted",
            Self::Displacement => "displacement",
            Self::Pressure => "contact pressure",
            Self::Depth => "tissue depth",
        }
    }

    /// Its unit, and how many of it make an SI unit.
    pub fn unit(self) -> (&'static str, f64) {
        match self {
            Self::None => ("", 1.0),
            Self::Displacement | Self::Depth => ("mm", 1e3),
            Self::Pressure => ("kPa", 1e-3),
        }
    }

    /// The smallest value of the darkest colour, in SI units: what is less hardly shows.
    fn least(self) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Displacement | Self::Depth => 2e-3,
            Self::Pressure => 2e3,
        }
    }
}

/// The skin as it is shown.
#[derive(Debug, Default)]
pub struct Shown {
    /// m, in the world.
    pub positions: Vec<DVec3>,
    /// Unit, but where a vertex has none.
    pub normals: Vec<DVec3>,
    /// U φ, m.
    pub displacement: Vec<DVec3>,
    /// Of contact, N; read where they are shown.
    pub forces: Vec<DVec3>,
    /// Pa; read where they are shown.
    pub pressures: Vec<f64>,
    /// Which values colour it.
    map: ValueMap,
    /// The value of the darkest colour, SI.
    pub most: f64,
    /// A colour for each vertex and how much of it is seen.
    pub colours: Vec<[f32; 4]>,
    /// Whether the skin is coloured, or was when it was read before: then the colours are news.
    pub coloured: bool,
    was_coloured: bool,
}

impl Shown {
    /// Of a character that has not been read yet.
    pub fn new(character: &Character) -> Self {
        Self {
            colours: vec![[0.0; 4]; character.avatar.skin.len()],
            ..Self::default()
        }
    }

    /// Which values colour it.
    pub fn map(&self) -> ValueMap {
        self.map
    }

    /// Has other values colour it from the next time on that it is read.
    pub fn set_map(&mut self, map: ValueMap) {
        if map != self.map {
            (self.map, self.most) = (map, 0.0);
        }
    }

    /// Colours the skin by the chosen values. The scale follows them: up at once, down slowly.
    pub fn colour(&mut self, character: &Character) {
        let count = character.avatar.skin.len();
        let value = |v: usize| match self.map {
            ValueMap::None => 0.0,
            ValueMap::Displacement => self.displacement.get(v).map_or(0.0, |d| d.length()),
            ValueMap::Pressure => self.pressures.get(v).copied().unwrap_or(0.0),
            ValueMap::Depth => character.depths.get(v).copied().unwrap_or(0.0),
        };
        let largest = (0..count).map(value).fold(self.map.least(), f64::max);
        let most = largest.max(0.99 * self.most);
        let opacity = if self.map == ValueMap::None { 0.0 } else { 1.0 };
        let tissue = character.avatar.tissue_vertices();
        let colour = |v: usize| {
            let [r, g, b] = colour_map(value(v) / most);
            [r, g, b, if v < tissue { opacity } else { 0.0 }]
        };
        let coloured = self.map != ValueMap::None;
        self.coloured = coloured || self.was_coloured;
        if self.coloured {
            let colours: Vec<_> = (0..count).map(colour).collect();
            self.colours = colours;
        }
        self.was_coloured = coloured;
        self.most = most;
    }
}
