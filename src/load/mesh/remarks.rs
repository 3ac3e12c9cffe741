//! What a mesh file says beyond its triangles, and what of that is left out.

use std::fmt;

use super::polygons::Replaced;

/// Names that are kept to be shown; of more it is only known that there are more.
const MOST_NAMES: usize = 5;

/// What is not as the file says, or not as it may be meant.
#[derive(Clone, Debug, Default)]
pub struct Remarks {
    /// The materials that an OBJ file names.
    pub materials: Materials,
    /// Statements of an OBJ file that describe what is no polygon, or change how others are shown.
    pub(super) statements: Statements,
    /// Polygons that cross themselves, which are cut as fans.
    pub(super) crossing: usize,
    /// Vertices whose texture coordinates are not finite, which count as 0.
    pub(super) not_finite_uvs: usize,
    /// Whether faces of one mesh name several textures.
    pub(super) several_textures: bool,
    /// Whether some faces have texture coordinates and others have none.
    pub some_lack_uvs: bool,
    /// Fans that were replaced.
    pub(in crate::load) replaced: Vec<Replaced>,
}

/// Materials that an OBJ file names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Materials {
    /// The files that are to define them (`mtllib`).
    pub libraries: Names,
    /// Those that faces ask for (`usemtl`).
    pub used: Names,
}

/// A few different names, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Names {
    first: Vec<String>,
    more: bool,
}

impl Names {
    /// Adds a name, unless it is there.
    pub(super) fn add(&mut self, name: &str) {
        if self.first.iter().any(|n| n == name) || name.is_empty() {
        } else if self.first.len() < MOST_NAMES {
            self.first.push(name.to_owned());
        } else {
            self.more = true;
        }
    }

    fn append(&mut self, other: &Self) {
        other.first.iter().for_each(|name| self.add(name));
        self.more |= other.more;
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.first.is_empty()
    }

    /// Whether there are at least two.
    #[must_use]
    pub fn are_several(&self) -> bool {
        self.first.len() > 1
    }
}

/// `` `a`, `b`, … ``
impl fmt::Display for Names {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, name) in self.first.iter().enumerate() {
            write!(f, "{}`{name}`", if i > 0 { ", " } else { "" })?;
        }
        f.write_str(if self.more { ", …" } else { "" })
    }
}

impl Materials {
    pub(super) fn append(&mut self, other: &Self) {
        self.libraries.append(&other.libraries);
        self.used.append(&other.used);
    }
}

/// Statements of the OBJ format (Wavefront, Advanced Visualizer, appendix B) that are no polygons.
const STATEMENTS: [&str; 32] = [
    // Free-form geometry, of today and superseded.
    "vp",
    "cstype",
    "deg",
    "bmat",
    "step",
    "curv",
    "curv2",
    "surf",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "bsp",
    "bzp",
    "cdc",
    "cdp",
    "res",
    // What else is drawn.
    "l",
    "p",
    // How others are to show it.
    "mg",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "shadow_obj",
    "trace_obj",
    "usemap",
    "maplib",
    "ctech",
];
const FREE_FORM: u64 = (1 << 20) - 1;
const LINES_AND_POINTS: u64 = 0b11 << 20;

/// Which of [`STATEMENTS`] occur, a bit for each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Statements(u64);

impl Statements {
    /// Notes a keyword; false if it is none of the format's.
    pub(super) fn note(&mut self, keyword: &[u8]) -> bool {
        let index = match keyword {
            // Both are about how surfaces are cut for drawing.
            b"stech" => STATEMENTS.len() - 1,
            _ => match STATEMENTS.iter().position(|s| s.as_bytes() == keyword) {
                Some(index) => index,
                None => return false,
            },
        };
        self.0 |= 1 << index;
        true
    }

    pub(super) fn append(&mut self, other: Self) {
        self.0 |= other.0;
    }

    /// `` `curv`, `surf` ``; nothing if none of `these` occurs.
    fn listed(self, these: u64) -> Option<String> {
        let found = self.0 & these;
        let names = (0..STATEMENTS.len()).filter(|i| found >> i & 1 == 1);
        let names: Vec<_> = names.map(|i| format!("`{}`", STATEMENTS[i])).collect();
        (!names.is_empty()).then(|| names.join(", "))
    }
}

impl Remarks {
    /// What is left out or changed, and what can be done about it; of materials and texture coordinates only
    /// those know whether they are missed who use the mesh.
    #[must_use]
    pub fn warnings(&self) -> Vec<(String, String)> {
        let mut warnings = Vec::new();
        let mut warn = |text: String, help: &str| warnings.push((text, help.to_owned()));
        if let Some(names) = self.statements.listed(FREE_FORM) {
            let help = "let the program that wrote the file make polygons of them";
            warn(format!("free-form curves and surfaces are left out ({names})"), help);
        }
        if let Some(names) = self.statements.listed(LINES_AND_POINTS) {
            warn(format!("lines and points are left out ({names})"), "only faces can be seen");
        }
        if let Some(names) = self.statements.listed(!FREE_FORM & !LINES_AND_POINTS) {
            let help = "they are about how other programs show the polygons";
            warn(format!("statements without effect are left out ({names})"), help);
        }
        let counted = |count: usize, one: &str, several: &str| {
            format!("{count} {}", if count == 1 { one } else { several })
        };
        if self.crossing > 0 {
            let what =
                counted(self.crossing, "polygon crosses itself", "polygons cross themselves");
            let help = "cut such faces into triangles in the program that they come from";
            warn(format!("{what}, and may cover too much"), help);
        }
        if self.not_finite_uvs > 0 {
            let what = counted(self.not_finite_uvs, "vertex has", "vertices have");
            let help = "unwrap the mesh anew in the program that it comes from";
            warn(format!("{what} texture coordinates that are not finite and count as 0"), help);
        }
        if self.several_textures {
            let help = "write a file for each texture, and give each a shape of its own";
            warn(
                "faces name several textures (`texnumber`): all show that of the shape".into(),
                help,
            );
        }
        warnings
    }
}
