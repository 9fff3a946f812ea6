//! Colours in linear RGB, as glTF has them.

/// What rigid bodies look like.
pub const BODY_COLOUR: u32 = 0xc9a227;

/// Linear RGB, each in 0..1.
pub type Colour = [f32; 3];

/// The linear colour of an sRGB one written `0xRRGGBB` (IEC 61966-2-1).
pub fn from_srgb(hex: u32) -> Colour {
    [16, 8, 0].map(|shift| {
        let c = ((hex >> shift) & 0xff) as f32 / 255.0;
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    })
}
