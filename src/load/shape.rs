//! Shapes of scene files.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3A};

use super::mesh_file::MeshFile;
use super::mtl::Surface;
use super::plugins::{Build, Category, Part, Plugin};
use super::problem::Issue;
use super::properties::Object;
use crate::math::Frame;
use crate::property::{Bounds, Default, Kind, PropertyInfo, property};
use crate::ray::Ray;
use crate::shape::mesh::Dropped;
use crate::shape::{Cylinder, Disk, Group, Instance, Shape, Sphere, TriangleMesh, primitives};

/// A shape and the triangles that it lost.
#[derive(Debug)]
pub(super) struct BuiltShape {
    pub(super) shape: Arc<dyn Shape>,
    /// The same, if it is a mesh.
    pub(super) mesh: Option<Arc<TriangleMesh>>,
    pub(super) dropped: Dropped,
    pub(super) file: Option<MeshFile>,
    /// What its file says that it is made of, with the name of that.
    pub(super) surface: Option<(String, Surface)>,
}

impl BuiltShape {
    /// A shape that is no mesh.
    pub(super) fn new(shape: Arc<dyn Shape>) -> Self {
        Self { shape, mesh: None, dropped: Dropped::default(), file: None, surface: None }
    }

    /// A mesh that is whole.
    pub(super) fn from_mesh(mesh: Arc<TriangleMesh>) -> Self {
        Self { mesh: Some(mesh.clone()), ..Self::new(mesh) }
    }
}

pub(super) const PARTS: &[Part] =
    &[Part::optional(Category::Bsdf), Part::optional(Category::Emitter)];

pub(super) const TO_WORLD: PropertyInfo =
    property("to_world", Kind::Motion, Default::Identity, "maps the shape into the scene");

pub(super) const FLIP_NORMALS: PropertyInfo = property(
    "flip_normals",
    Kind::Boolean,
    Default::Boolean(false),
    "turn the normals to the other side",
);

pub(super) static RECTANGLE: Plugin = Plugin {
    name: "rectangle",
    help: "The square from (-1, -1) to (1, 1) in the plane z = 0, facing +z.",
    properties: &[TO_WORLD, FLIP_NORMALS],
    parts: PARTS,
    build: Build::Shape(|object| primitive(object, primitives::rectangle)),
};

pub(super) static CUBE: Plugin = Plugin {
    name: "cube",
    help: "The cube from (-1, -1, -1) to (1, 1, 1), facing outwards.",
    properties: &[TO_WORLD, FLIP_NORMALS],
    parts: PARTS,
    build: Build::Shape(|object| primitive(object, primitives::cube)),
};

pub(super) static SPHERE: Plugin = Plugin {
    name: "sphere",
    help: "A sphere, facing outwards.",
    properties: &[
        property("center", Kind::Point, Default::Origin, "before `to_world`"),
        property("radius", Kind::Float(Bounds::Positive), Default::Float(1.0), "before `to_world`"),
        property(
            "to_world",
            Kind::Motion,
            Default::Identity,
            "maps it into the scene; rotation, translation and a scale that is the same along all axes",
        ),
        FLIP_NORMALS,
    ],
    parts: PARTS,
    build: Build::Shape(sphere),
};

pub(super) static DISK: Plugin = Plugin {
    name: "disk",
    help: "The disk of radius 1 in the plane z = 0, facing +z.",
    properties: &[TO_WORLD, FLIP_NORMALS],
    parts: PARTS,
    build: Build::Shape(disk),
};

pub(super) static CYLINDER: Plugin = Plugin {
    name: "cylinder",
    help: "A circular cylinder without caps, facing outwards.",
    properties: &[
        property("p0", Kind::Point, Default::Origin, "middle of one end, before `to_world`"),
        property(
            "p1",
            Kind::Point,
            Default::Absent("0, 0, 1"),
            "middle of the other end, before `to_world`",
        ),
        property("radius", Kind::Float(Bounds::Positive), Default::Float(1.0), "before `to_world`"),
        property(
            "to_world",
            Kind::Transform,
            Default::Identity,
            "maps it into the scene; it must stay circular",
        ),
        FLIP_NORMALS,
    ],
    parts: PARTS,
    build: Build::Shape(cylinder),
};

pub(super) static SHAPEGROUP: Plugin = Plugin {
    name: "shapegroup",
    help: "Shapes that are not seen themselves, but wherever an `instance` places them.",
    properties: &[],
    parts: &[Part { category: Category::Shape, least: 1, most: u32::MAX as usize }],
    build: Build::Group,
};

pub(super) static INSTANCE: Plugin = Plugin {
    name: "instance",
    help: "The shapes of a `shapegroup` in one more place; they are stored once.",
    properties: &[property(
        "to_world",
        Kind::Motion,
        Default::Identity,
        "maps the group into the scene",
    )],
    parts: &[Part { category: Category::Shape, least: 1, most: 1 }],
    build: Build::Instance,
};

/// The instance of `group` that an object describes.
///
/// # Errors
/// A map that flattens the group, or reaches too far.
pub(super) fn instance(object: &Object<'_>, group: Arc<Group>) -> Result<BuiltShape, Issue> {
    let shape = match object.motion("to_world") {
        Some(motion) => Instance::moving(group, motion),
        None => Instance::new(group, object.transform("to_world")),
    };
    let shape =
        shape.map_err(|error| Issue::new(object.place_of("to_world"), error.to_string()))?;
    Ok(BuiltShape::new(Arc::new(shape)))
}

/// The shape that an object describes.
///
/// # Errors
/// A mesh file that cannot be read, a map that does not suit the shape, nothing left to hit.
pub(super) fn build(object: &Object<'_>) -> Result<BuiltShape, Issue> {
    match object.plugin().build {
        Build::Shape(build) => build(object),
        _ => unreachable!("callers pass shapes that are built by themselves"),
    }
}

fn primitive(
    object: &Object<'_>,
    make: fn(DAffine3, bool) -> (TriangleMesh, Dropped),
) -> Result<BuiltShape, Issue> {
    let (mesh, dropped) = make(object.transform("to_world"), object.boolean("flip_normals"));
    from_mesh(object, mesh, dropped)
}

pub(super) fn from_mesh(
    object: &Object<'_>,
    mesh: TriangleMesh,
    dropped: Dropped,
) -> Result<BuiltShape, Issue> {
    if mesh.triangles().is_empty() && flattens(object.transform("to_world").matrix3) {
        let message =
            "`to_world` leaves no area of the shape: it scales an axis by 0, or by next to 0";
        let help = "scale by more than 0 along each axis in which the shape extends";
        return Err(Issue::new(object.place_of("to_world"), message).with_help(help));
    }
    if mesh.triangles().is_empty() {
        let name = object.plugin().name;
        let message = format!("shape `{name}` has no triangle with an area and finite vertices");
        return Err(Issue::new(object.place(), message).with_help(format!(
            "keep all coordinates below {:e} and above what a 32-bit float can hold",
            Ray::LARGEST_COORDINATE
        )));
    }
    Ok(BuiltShape { dropped, ..BuiltShape::from_mesh(Arc::new(mesh)) })
}

/// Whether a map scales an axis by 0, or by next to 0 beside the others.
fn flattens(map: DMat3) -> bool {
    let largest = map.x_axis.abs().max(map.y_axis.abs()).max(map.z_axis.abs()).max_element();
    // What a product of rotations and a scale by 0 leaves is of the order of 1e-16.
    largest == 0.0 || (map * (1.0 / largest)).determinant().abs() < 1e-12
}

fn sphere(object: &Object<'_>) -> Result<BuiltShape, Issue> {
    let to_world = object.transform("to_world");
    let (scale, axes) = similarity(to_world.matrix3).ok_or_else(|| {
        let message = "`to_world` of a sphere must scale all axes alike, and not to 0";
        Issue::new(object.place_of("to_world"), message).with_help("an ellipsoid has to be a mesh")
    })?;
    let center = to_world.transform_point3(object.point("center")).as_vec3a();
    let radius = (object.float("radius") * scale.abs()) as f32;
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(Issue::new(
            object.place(),
            format!(
                "a sphere cannot have a radius of {radius} (expected: {:e} to {:e}, after `to_world`)",
                f32::from_bits(1),
                f32::MAX
            ),
        ));
    }
    // A map that mirrors turns the normals, as in Mitsuba.
    let inwards = (scale < 0.0) != object.boolean("flip_normals");
    analytic(object, Sphere::new(center, radius, axes, inwards))
}

/// Scene files print matrices with six digits or more, which errs by 5e-7 for each entry, and by three
/// times the double of that for an entry of MᵀM.
const TOLERANCE: f64 = 1e-5;

/// The factor `s` and the rotation `R` of a map `s R`; `None` if it is no such map. `s` is negative if the
/// map mirrors.
fn similarity(map: DMat3) -> Option<(f64, Frame)> {
    let largest = map.to_cols_array().into_iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    // Scaled first, so that no product leaves the range.
    let unit = map * (1.0 / largest);
    let scale = unit.determinant().cbrt();
    let rotation = unit * (1.0 / scale);
    let deviation = (rotation.transpose() * rotation - DMat3::IDENTITY).to_cols_array();
    let similar = deviation.into_iter().all(|d| d.abs() <= TOLERANCE);
    let axis = |v: DVec3| v.normalize().as_vec3().into();
    similar.then(|| {
        let [s, t, n] = [rotation.x_axis, rotation.y_axis, rotation.z_axis].map(axis);
        (scale * largest, Frame { s, t, n })
    })
}

fn disk(object: &Object<'_>) -> Result<BuiltShape, Issue> {
    let disk = Disk::new(object.transform("to_world"), object.boolean("flip_normals"));
    let disk = disk.ok_or_else(|| {
        Issue::new(
            object.place_of("to_world"),
            "`to_world` of a disk must not flatten it: it is singular",
        )
    })?;
    analytic(object, disk)
}

fn cylinder(object: &Object<'_>) -> Result<BuiltShape, Issue> {
    let to_world = object.transform("to_world");
    let base = object.point("p0");
    let along = if object.has("p1") { object.point("p1") } else { DVec3::Z } - base;
    let Some(axis) = along.try_normalize() else {
        let message = "a cylinder cannot begin and end at one point";
        return Err(Issue::new(object.place_of("p1"), message));
    };
    let frame = Frame::from_normal(axis.as_vec3a().into());
    let across = [frame.s, frame.t].map(|v| Vec3A::from(v).as_dvec3() * object.float("radius"));
    let axes = [across[0], across[1], along].map(|v| to_world.transform_vector3(v));
    let cylinder = is_circular(axes)
        .then(|| {
            let base = to_world.transform_point3(base);
            Cylinder::new(base, axes, object.boolean("flip_normals"))
        })
        .flatten();
    let cylinder = cylinder.ok_or_else(|| {
        let message = "`to_world` of a cylinder must keep it circular, and not flatten it";
        Issue::new(object.place_of("to_world"), message)
            .with_help("an elliptic or slanted cylinder has to be a mesh")
    })?;
    analytic(object, cylinder)
}

/// Whether the axes of a cylinder are orthogonal, and the first two of one length: as far as the digits of
/// scene files tell, as in [`similarity`].
fn is_circular([x, y, z]: [DVec3; 3]) -> bool {
    let (Some(to_x), Some(to_y), Some(to_z)) =
        (x.try_normalize(), y.try_normalize(), z.try_normalize())
    else {
        return false;
    };
    let cosines = [to_x.dot(to_y), to_x.dot(to_z), to_y.dot(to_z)];
    cosines.into_iter().all(|c| c.abs() <= TOLERANCE)
        && (x.length() / y.length() - 1.0).abs() <= TOLERANCE
}

fn analytic<S: Shape + 'static>(object: &Object<'_>, shape: S) -> Result<BuiltShape, Issue> {
    let bounds = Shape::bounds(&shape);
    let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
    // NaN compares as false and is refused too.
    if reach < Ray::LARGEST_COORDINATE {
        return Ok(BuiltShape::new(Arc::new(shape)));
    }
    let message = format!("shape `{}` reaches farther than coordinates may", object.plugin().name);
    Err(Issue::new(object.place(), message)
        .with_help(format!("keep all coordinates below {:e}", Ray::LARGEST_COORDINATE)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn similarities_are_told_from_other_maps() {
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 1.0);
        for scale in [1.0, 1e-200, 1e200, -3.0] {
            let (found, _) = similarity(turn * scale).expect("a rotation times a factor");
            assert!((found / scale - 1.0).abs() < 1e-12, "{scale} {found}");
        }
        // Six digits of a rotation still are one; a difference of 1 in 1000 is none.
        let rounded =
            DMat3::from_cols_array(&turn.to_cols_array().map(|v| (v * 1e6).round() * 1e-6));
        assert!(similarity(rounded).is_some());
        let scaled = |x, y, z| turn * DMat3::from_diagonal(DVec3::new(x, y, z));
        for map in [scaled(1.0, 1.0, 1.001), scaled(1.0, 0.0, 1.0), scaled(0.0, 0.0, 0.0)] {
            assert!(similarity(map).is_none(), "{map}");
        }
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(1e-3, 1.0, 0.0), DVec3::Z);
        assert!(similarity(shear).is_none());
    }
}
