//! STL as bytes: 80 that mean nothing, the number of facets, 50 for each of them; little-endian.

use glam::{DVec3, Vec3A};

use super::super::buffers::Placement;
use super::super::bytes::Bytes;
use super::super::error::{Fault, MeshProblem, Place};
use super::super::source::Source;

/// Bytes before the first facet.
const HEADER: u64 = 84;
/// Bytes of a facet.
const FACET: usize = 50;
const NORMAL: u64 = 12;
const ATTRIBUTE: u64 = 2;

/// The corners of all triangles.
pub(super) fn read(source: Source, placement: &Placement) -> Result<Vec<Vec3A>, Fault> {
    let mut bytes = Bytes::new(source, 0, false);
    if !bytes.remaining(HEADER as usize)? {
        return Err(MeshProblem::NotStl.into());
    }
    bytes.skip_bytes(HEADER - 4)?;
    let count = u32::from_le_bytes(bytes.next()?);
    let possible = bytes.source().possible(count.into(), FACET as u64);
    super::check_count((possible as usize).saturating_mul(3))?;
    super::claim(bytes.source(), possible)?;
    let likely = bytes.source().plausible(count.into(), FACET as u64);
    let mut corners = Vec::with_capacity(3 * likely);
    for number in 0..u64::from(count) {
        if !bytes.remaining(FACET)? {
            let (element, count, found) = ("facet".to_owned(), count.into(), number);
            let place = Place::Record { offset: bytes.end(), element: element.clone(), number };
            return Err(Fault::new(place, MeshProblem::Truncated { element, count, found }));
        }
        bytes.skip_bytes(NORMAL)?;
        for _ in 0..3 {
            let mut float = || Ok::<_, Fault>(f64::from(f32::from_le_bytes(bytes.next()?)));
            let point = DVec3::new(float()?, float()?, float()?);
            corners.push(placement.position(point));
        }
        bytes.skip_bytes(ATTRIBUTE)?;
    }
    if bytes.remaining(1)? { Err(MeshProblem::TrailingData.into()) } else { Ok(corners) }
}
