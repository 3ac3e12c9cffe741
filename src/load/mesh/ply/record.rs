//! What the records of a PLY file mean, in whichever encoding they are written.

use glam::{DVec3, Vec2};

use super::super::buffers::{Buffers, Placement};
use super::super::error::{Fault, MeshProblem, Place};
use super::super::source::Source;
use super::header::{Element, Encoding, Header, Kind, Property, Scalar};
use super::wedges::Wedges;

/// Where values come from: text or bytes.
pub(super) trait Values {
    fn number(&mut self, scalar: Scalar) -> Result<f64, Fault>;
    /// Only for types that are integers.
    fn integer(&mut self, scalar: Scalar) -> Result<i64, Fault>;
    /// Steps over so many values.
    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), Fault>;
    /// A problem with the value that was read last.
    fn fault(&self, problem: MeshProblem) -> Fault;
}

/// The names of the vertex properties in use. Their order is that of [`Vertex`].
const NAMES: [&[&str]; SLOTS] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["u", "s", "texture_u", "texture_s"],
    &["v", "t", "texture_v", "texture_t"],
];
const SLOTS: usize = 8;
/// Position, normal and texture coordinates, and a last place for what nobody asked for.
type Vertex = [f64; SLOTS + 1];

/// What was read of a file, or of a piece of it.
#[derive(Debug, Default)]
pub(super) struct Content {
    pub(super) buffers: Buffers,
    /// Empty if the file has no texture coordinates for corners.
    pub(super) wedges: Wedges,
    /// Those of the face that is being read.
    face_uvs: Vec<f64>,
}

impl Content {
    /// Adds the next piece of a file.
    pub(super) fn append(&mut self, piece: &Self) {
        self.buffers.append(&piece.buffers);
        self.wedges.append(&piece.wedges);
    }
}

/// What is read of an element's records.
#[derive(Debug)]
enum Role {
    /// Vertices: the place of each property in a [`Vertex`].
    Vertex(Vec<usize>),
    /// Faces: which property is the list of vertex indices; which, if any, is the list of texture coordinates
    /// and which the number of a texture.
    Face {
        indices: usize,
        uvs: Option<usize>,
        texture: Option<usize>,
    },
    Skip,
}

/// How to read the records of a file.
#[derive(Debug)]
pub(super) struct Records<'a> {
    elements: Vec<(&'a Element, Role)>,
    vertices: u64,
    has_normals: bool,
    has_uvs: bool,
    placement: Placement,
    /// Whether the records are lines of text.
    text: bool,
}

impl<'a> Records<'a> {
    /// Understands a header, or says what is missing in it.
    pub(super) fn new(
        header: &'a Header,
        face_normals: bool,
        placement: Placement,
    ) -> Result<Self, Fault> {
        let mut elements = Vec::with_capacity(header.elements.len());
        for element in &header.elements {
            let at = Place::Line { line: element.line, column: 1 };
            let role = role(element).map_err(|why| Fault::new(at, MeshProblem::Header(why)))?;
            elements.push((element, role));
        }
        let one = |name: &str| {
            let mut named = elements.iter().filter(|(element, _)| element.name == name);
            match (named.next(), named.next()) {
                (Some((element, _)), None) => Ok(element),
                _ => Err(MeshProblem::Header(format!("expected one element `{name}`"))),
            }
        };
        if elements.iter().all(|(element, _)| element.name != "face") {
            let vertices = usize::try_from(one("vertex")?.count).unwrap_or(usize::MAX);
            return Err(MeshProblem::NoFaces { vertices }.into());
        }
        one("face")?;
        let vertex = one("vertex")?;
        let has = |slots: std::ops::Range<usize>| {
            slots.into_iter().all(|slot| vertex.properties.iter().any(|p| slot_of(p) == slot))
        };
        Ok(Self {
            vertices: vertex.count,
            has_normals: has(3..6) && !face_normals,
            has_uvs: has(6..8),
            placement,
            text: header.encoding == Encoding::Ascii,
            elements,
        })
    }

    /// Makes room for what the header declares, as far as the file can hold it.
    pub(super) fn reserve(&self, source: &Source, buffers: &mut Buffers) -> Result<(), Fault> {
        for (element, role) in &self.elements {
            let bytes = match role {
                Role::Vertex(_) => Buffers::vertex_bytes(self.has_normals, self.has_uvs),
                Role::Face { .. } => Buffers::TRIANGLE_BYTES,
                Role::Skip => 0,
            };
            let count = source.possible(element.count, self.least_bytes(element));
            source.claim(count.saturating_mul(bytes))?;
        }
        for (element, role) in &self.elements {
            let count = source.plausible(element.count, self.least_bytes(element));
            match role {
                Role::Vertex(_) => {
                    buffers.positions.reserve_exact(count);
                    buffers.normals.reserve_exact(if self.has_normals { count } else { 0 });
                    buffers.uvs.reserve_exact(if self.has_uvs { count } else { 0 });
                }
                Role::Face { .. } => buffers.triangles.reserve_exact(count),
                Role::Skip => {}
            }
        }
        Ok(())
    }

    /// How few bytes a record can take: in text a digit and a separator for each value.
    fn least_bytes(&self, element: &Element) -> u64 {
        let size = |scalar: Scalar| if self.text { 2 } else { scalar.size() as u64 };
        let of = |property: &Property| match property.kind {
            Kind::Scalar(scalar) => size(scalar),
            Kind::List { count, .. } => size(count),
        };
        element.properties.iter().map(of).sum()
    }

    /// The elements, in the order of the data.
    pub(super) fn elements(&self) -> impl Iterator<Item = &'a Element> {
        self.elements.iter().map(|&(element, _)| element)
    }

    /// Reads one record of the element at `index` among the elements.
    pub(super) fn read(
        &self,
        index: usize,
        values: &mut impl Values,
        out: &mut Content,
    ) -> Result<(), Fault> {
        let (element, role) = &self.elements[index];
        match role {
            Role::Vertex(slots) => self.read_vertex(element, slots, values, &mut out.buffers),
            &Role::Face { indices, uvs, texture } => {
                let before = out.buffers.triangles.len();
                out.face_uvs.clear();
                for (i, property) in element.properties.iter().enumerate() {
                    match property.kind {
                        Kind::List { count, item } if i == indices => {
                            self.read_face(count, item, values, &mut out.buffers)?;
                        }
                        Kind::List { count, item } if uvs == Some(i) => {
                            for _ in 0..length(count, values)? {
                                out.face_uvs.push(values.number(item)?);
                            }
                        }
                        Kind::Scalar(scalar) if texture == Some(i) => {
                            out.wedges.texture(values.integer(scalar)?);
                        }
                        kind => skip(kind, values)?,
                    }
                }
                let triangles = out.buffers.triangles.len() - before;
                if uvs.is_some() { self.wedge(triangles, values, out) } else { Ok(()) }
            }
            Role::Skip => element.properties.iter().try_for_each(|p| skip(p.kind, values)),
        }
    }

    fn read_vertex(
        &self,
        element: &Element,
        slots: &[usize],
        values: &mut impl Values,
        out: &mut Buffers,
    ) -> Result<(), Fault> {
        let mut vertex = [0.0; SLOTS + 1];
        for (property, &slot) in element.properties.iter().zip(slots) {
            match property.kind {
                Kind::Scalar(scalar) => vertex[slot] = values.number(scalar)?,
                kind @ Kind::List { .. } => skip(kind, values)?,
            }
        }
        let [x, y, z, nx, ny, nz, u, v, _]: Vertex = vertex;
        out.positions.push(self.placement.position(DVec3::new(x, y, z)));
        if self.has_normals {
            out.normals.push(self.placement.normal(DVec3::new(nx, ny, nz)));
        }
        if self.has_uvs {
            out.uvs.push(self.placement.uv(u, v));
        }
        Ok(())
    }

    fn read_face(
        &self,
        count: Scalar,
        item: Scalar,
        values: &mut impl Values,
        out: &mut Buffers,
    ) -> Result<(), Fault> {
        let corners = values.integer(count)?;
        if corners < 3 {
            return Err(values.fault(MeshProblem::TooFewCorners { count: corners }));
        }
        let first = self.read_index(item, values)?;
        let mut previous = self.read_index(item, values)?;
        for _ in 2..corners {
            let next = self.read_index(item, values)?;
            out.triangles.push([first, previous, next]);
            previous = next;
        }
        // As many values were there.
        out.polygons.push(usize::try_from(corners).unwrap_or(usize::MAX));
        Ok(())
    }

    /// Gives the corners of the last face, of so many triangles, the texture coordinates that were read.
    fn wedge(
        &self,
        triangles: usize,
        values: &impl Values,
        out: &mut Content,
    ) -> Result<(), Fault> {
        let (corners, found) = (triangles + 2, out.face_uvs.len());
        if found != 0 && found != 2 * corners {
            let expected = 2 * corners;
            return Err(values.fault(MeshProblem::TextureCoordinateCount {
                found,
                corners,
                expected,
            }));
        }
        let uvs = out.face_uvs.chunks_exact(2).map(|uv| self.placement.uv(uv[0], uv[1]));
        out.wedges.push(&uvs.collect::<Vec<Vec2>>(), triangles);
        Ok(())
    }

    fn read_index(&self, item: Scalar, values: &mut impl Values) -> Result<u32, Fault> {
        let index = values.integer(item)?;
        match u32::try_from(index) {
            Ok(vertex) if u64::from(vertex) < self.vertices => Ok(vertex),
            _ => Err(values.fault(MeshProblem::IndexOutOfRange {
                attribute: "vertex index",
                index,
                count: self.vertices,
            })),
        }
    }
}

/// Steps over a property.
fn skip(kind: Kind, values: &mut impl Values) -> Result<(), Fault> {
    match kind {
        Kind::Scalar(scalar) => values.skip(scalar, 1),
        Kind::List { count, item } => {
            let count = length(count, values)?;
            values.skip(item, count)
        }
    }
}

/// The number of entries of a list.
fn length(count: Scalar, values: &mut impl Values) -> Result<u64, Fault> {
    let count = values.integer(count)?;
    u64::try_from(count).map_err(|_| values.fault(MeshProblem::NegativeCount { count }))
}

/// Where a property goes in a [`Vertex`].
fn slot_of(property: &Property) -> usize {
    let named = |names: &&[&str]| names.contains(&property.name.as_str());
    match property.kind {
        Kind::Scalar(_) => NAMES.iter().position(named).unwrap_or(SLOTS),
        Kind::List { .. } => SLOTS,
    }
}

/// What an element is for; otherwise what is wrong with it.
fn role(element: &Element) -> Result<Role, String> {
    // A record of nothing has no place in the data, and there may be any number of them.
    if element.properties.is_empty() && element.count > 0 {
        return Err(format!("the element `{}` has no properties", element.name));
    }
    match element.name.as_str() {
        "vertex" => {
            let slots: Vec<_> = element.properties.iter().map(slot_of).collect();
            for (slot, names) in NAMES.iter().enumerate() {
                let found = slots.iter().filter(|&&s| s == slot).count();
                if found > 1 || (found == 0 && slot < 3) {
                    return Err(format!(
                        "the element `vertex` has {found} properties `{}` (expected one)",
                        names.join("` or `"),
                    ));
                }
            }
            Ok(Role::Vertex(slots))
        }
        "face" => {
            let is_list = |p: &Property| {
                matches!(p.name.as_str(), "vertex_indices" | "vertex_index")
                    && matches!(p.kind, Kind::List { item, .. } if item.is_integer())
            };
            let indices = element.properties.iter().position(is_list);
            let uvs = element
                .properties
                .iter()
                .position(|p| p.name == "texcoord" && matches!(p.kind, Kind::List { .. }));
            let texture = element.properties.iter().position(|p| {
                p.name == "texnumber" && matches!(p.kind, Kind::Scalar(s) if s.is_integer())
            });
            indices.map(|indices| Role::Face { indices, uvs, texture }).ok_or_else(|| {
                "the element `face` has no list `vertex_indices` or `vertex_index` of an integer \
                 type"
                    .into()
            })
        }
        "tristrips" => Err("triangle strips are not read (expected triangles or polygons in an \
                            element `face`)"
            .into()),
        _ => Ok(Role::Skip),
    }
}
