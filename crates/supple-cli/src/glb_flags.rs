//! How a run's GLB file is written.

use super::terminal::tell;
use std::path::Path;
use supple::Result;
use supple::model::Avatar;
use supple_files::{GlbOptions, MOST_MORPHS, Recording, write_glb_with};

/// Flags of a GLB file.
#[derive(clap::Args)]
pub struct GlbFlags {
    /// Most morph targets of avatar.glb: of more the less important are left out, and it is said what that misses.
    #[arg(long, default_value_t = MOST_MORPHS, value_name = "N")]
    morphs: usize,
}

impl GlbFlags {
    /// Writes `avatar.glb` in `folder`, and says on stderr what is in it.
    pub fn write(&self, avatar: &Avatar, recording: &Recording, folder: &Path) -> Result<()> {
        let options = GlbOptions {
            most_morphs: self.morphs,
        };
        let glb = write_glb_with(avatar, recording, options, folder.join("avatar.glb"))?;
        tell(format_args!(
            "avatar.glb: {} KiB, {} morphs that miss {:.4} mm at most, {} images",
            glb.bytes / 1024,
            glb.morphs,
            1e3 * glb.largest_morph_error,
            glb.images
        ));
        Ok(())
    }
}
