//! `telamon scene`.

use clap::Args;
use clap::error::ErrorKind;

use super::message::Failure;
use super::values::{self, Size};
use super::{Input, mesh, print, usage};

/// Write the scene that is made of a mesh, to go on from
#[derive(Args, Debug)]
#[command(
    after_help = "Rendering what is written gives the same picture, to the last bit, as rendering the mesh. Files are \
                  named as they were given, so it belongs into the current folder.\n\n\
                  Example: telamon scene bust.obj > bust.xml"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    input: Input,

    /// Columns and rows of the picture [default: 800x600]
    #[arg(long, value_name = "WxH", value_parser = values::size, help_heading = "Picture")]
    size: Option<Size>,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let Some(studio) = self.input.studio(self.size, 1)? else {
            let scene = self.input.scene.display();
            let message = format!("`{scene}` is no mesh (expected {})", mesh::READ);
            usage(ErrorKind::ValueValidation, &message)
        };
        print(studio.scene().as_bytes())
    }
}
