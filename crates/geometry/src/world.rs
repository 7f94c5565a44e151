//! A world of instanced meshes: closest hits, and whether two points see each other.

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use crate::{
    GeometryError, Isa, Mesh,
    epsilon::{MAX_COORDINATE, spawn_offset},
    hidden::Hidden,
    levels::{Baked, Nearest, Shared, split},
    phase::{self, Phase},
    placement::Placement,
    triangle::Shear,
};

/// A half-line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
}

/// A mesh put into the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Index of the mesh.
    pub mesh: u32,
    /// From the mesh's space to the world's.
    pub transform: DAffine3,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Which instance.
    pub instance: u32,
    /// Which triangle of its mesh.
    pub triangle: u32,
    /// Barycentric coordinate of vertex 1.
    pub u: f64,
    /// Barycentric coordinate of vertex 2.
    pub v: f64,
    /// Distance along the ray.
    pub t: f64,
}

/// An end of a shadow segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// The point.
    pub position: DVec3,
    /// Unit geometric normal, either side; zero for points in free space (a camera, a point light), which are not moved.
    pub normal: DVec3,
}

/// Instanced meshes with the trees that find what a ray hits.
#[derive(Debug)]
pub struct World {
    meshes: Vec<Mesh>,
    instances: Vec<Instance>,
    placements: Vec<Placement>,
    baked: Option<Baked>,
    shared: Option<Shared>,
    bounds: (DVec3, DVec3),
    /// How far off the surface rays start.
    offset: f64,
    hidden: Hidden,
    isa: Isa,
}

impl World {
    /// Checks the meshes and builds the search trees. Triangles that can never be hit are left out of them and counted.
    ///
    /// It is searched with the instructions that [`Isa::from_environment`] gives.
    pub fn build(meshes: Vec<Mesh>, instances: Vec<Instance>) -> Result<Self, GeometryError> {
        for (index, mesh) in meshes.iter().enumerate() {
            check_mesh(index, mesh)?;
        }
        if instances.len() > u32::MAX as usize {
            return Err(GeometryError::TooMany { what: "instances", count: instances.len() });
        }
        let isa = Isa::from_environment()?;
        let bounds = bounds_of(&meshes, &instances)?;
        let placements: Vec<Placement> = instances.iter().map(Placement::new).collect();
        let mut hidden = Hidden::new(&meshes, &placements);
        let (baked, shared) = split(&meshes, &placements, bounds, &mut hidden)?;
        let offset = spawn_offset(bounds.0, bounds.1);
        Ok(Self { meshes, instances, placements, baked, shared, bounds, offset, hidden, isa })
    }

    /// The same world, searched with other instructions; the answers are the same to the bit.
    pub fn with_isa(mut self, isa: Isa) -> Self {
        self.isa = isa;
        self
    }

    /// The instructions that it is searched with.
    pub fn isa(&self) -> Isa {
        self.isa
    }

    /// The box around all triangles, (lowest, highest) corner; zero for a world without triangles.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    /// The instances, as they were given.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// A mesh, as it was given. Panics if there is no such mesh.
    #[inline]
    pub fn mesh(&self, mesh: u32) -> &Mesh {
        &self.meshes[mesh as usize]
    }

    /// How many triangles an instance has, degenerate ones included. Panics if there is no such instance.
    pub fn triangle_count(&self, instance: u32) -> usize {
        self.mesh(self.placement(instance).mesh).triangles.len()
    }

    /// How many triangles of the meshes can never be hit, because they have no area or lie in the place of another.
    pub fn dropped_triangles(&self) -> usize {
        self.hidden.dropped_of_meshes()
    }

    /// Whether a ray can ever hit a triangle: it has an area, and none before it, in the order of instances and triangles, lies
    /// in its very place. Panics if there is no such instance.
    ///
    /// Two copies of a mesh in one place are known by their transforms, others by their corners, to the bit; copies of a
    /// mesh with several instances are not compared with other meshes.
    pub fn can_be_hit(&self, instance: u32, triangle: u32) -> bool {
        !self.hidden.has(self.placement(instance).mesh, instance, triangle)
    }

    #[inline]
    pub(crate) fn placement(&self, instance: u32) -> &Placement {
        &self.placements[instance as usize]
    }

    /// The vertices of a triangle, in the world. Panics if there is no such triangle.
    #[inline]
    pub fn triangle(&self, instance: u32, triangle: u32) -> [DVec3; 3] {
        let placement = self.placement(instance);
        let mesh = self.mesh(placement.mesh);
        mesh.triangles[triangle as usize].map(|vertex| placement.point(mesh.positions[vertex as usize]))
    }

    /// The closest hit with t > 0, on either side of a triangle. Of several at the same t, the one with the lowest
    /// (instance, triangle).
    // Not inlined, so that all callers share one copy of the search in the instruction cache.
    #[inline(never)]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let _phase = phase::enter(Phase::Traversal);
        let shear = Shear::new(ray.origin, ray.direction);
        let mut nearest = Nearest::NONE;
        if let Some(baked) = &self.baked {
            baked.closest(self.isa, &shear, ray, &mut nearest);
        }
        if let Some(shared) = &self.shared {
            shared.closest(self.isa, &self.placements, &shear, ray, &mut nearest);
        }
        nearest.hit()
    }

    /// Whether the open segment from `origin` to `origin + t_max * direction` is blocked.
    // As above.
    #[inline(never)]
    fn blocked(&self, origin: DVec3, direction: DVec3, t_max: f64) -> bool {
        let _phase = phase::enter(Phase::Traversal);
        let ray = Ray { origin, direction };
        let shear = Shear::new(origin, direction);
        self.baked.as_ref().is_some_and(|baked| baked.any(self.isa, &shear, &ray, t_max))
            || self.shared.as_ref().is_some_and(|s| s.any(self.isa, &self.placements, &shear, &ray, t_max))
    }

    /// The point from which rays leave `anchor` for the side that `direction` points to.
    #[inline]
    fn lifted(&self, anchor: &Anchor, direction: DVec3) -> DVec3 {
        let offset = if anchor.normal.dot(direction) < 0.0 { -self.offset } else { self.offset };
        anchor.position + anchor.normal * offset
    }

    /// How far off the surface rays start.
    #[inline]
    pub(crate) fn offset(&self) -> f64 {
        self.offset
    }

    /// The ray that leaves `anchor` along the unit vector `direction` without hitting the surface it starts on.
    #[inline]
    pub fn spawn(&self, anchor: &Anchor, direction: DVec3) -> Ray {
        Ray { origin: self.lifted(anchor, direction), direction }
    }

    /// The segment between two points, from its lexicographically lower end, both ends off their surface towards the other; `None`
    /// between points so near to each other that the offsets would pass.
    #[inline]
    pub(crate) fn segment(&self, a: &Anchor, b: &Anchor) -> Option<(DVec3, DVec3)> {
        let across = b.position - a.position;
        if across.length_squared() <= 4.0 * self.offset * self.offset {
            return None;
        }
        let (a, b) = (self.lifted(a, across), self.lifted(b, -across));
        Some(if a.to_array() <= b.to_array() { (a, b) } else { (b, a) })
    }

    /// Whether nothing lies strictly between two points. Swapping them gives the same answer: both leave their surface
    /// towards the other, and the segment is always traced from the lexicographically lower end.
    ///
    /// Points so near to each other that the offsets would pass are never visible: no direction between them can be
    /// trusted, and they are met only where one point was computed twice.
    #[inline]
    pub fn visible(&self, a: &Anchor, b: &Anchor) -> bool {
        self.segment(a, b).is_some_and(|(low, high)| !self.blocked(low, high - low, 1f64.next_down()))
    }

    /// Whether nothing lies between a point and infinity along the unit vector `direction`.
    #[inline]
    pub fn escapes(&self, a: &Anchor, direction: DVec3) -> bool {
        !self.blocked(self.lifted(a, direction), direction, f64::MAX)
    }
}

fn in_range(p: DVec3) -> bool {
    // Written so that NaN is out of range; the maximum of components would ignore it.
    p.abs().cmple(DVec3::splat(MAX_COORDINATE)).all()
}

/// The box around all triangles of checked meshes; zero if there are none.
fn bounds_of(meshes: &[Mesh], instances: &[Instance]) -> Result<(DVec3, DVec3), GeometryError> {
    let of_instance = |(index, instance): (usize, &Instance)| {
        let Some(mesh) = meshes.get(instance.mesh as usize) else {
            return Err(GeometryError::MeshIndex { instance: index, mesh: instance.mesh, meshes: meshes.len() });
        };
        let of_triangle = |bounds: Option<_>, corners: &[u32; 3]| {
            corners.iter().try_fold(bounds?, |bounds, vertex| {
                let p = instance.transform.transform_point3(mesh.positions[*vertex as usize]);
                in_range(p).then_some(around(bounds, (p, p)))
            })
        };
        let triangles = mesh.triangles.par_iter().with_min_len(MIN_TRIANGLES);
        let bounds =
            triangles.fold(|| Some(NOTHING), of_triangle).reduce(|| Some(NOTHING), |a, b| Some(around(a?, b?)));
        bounds
            .filter(|_| instance.transform.is_finite())
            .ok_or(GeometryError::Transform { instance: index, mesh: instance.mesh })
    };
    // Of several errors the first is returned, on any number of threads.
    let of_instances: Vec<_> = instances.par_iter().enumerate().map(of_instance).collect();
    let bounds = of_instances.into_iter().try_fold(NOTHING, |all, bounds| Ok(around(all, bounds?)))?;
    Ok(if bounds.0.x > bounds.1.x { (DVec3::ZERO, DVec3::ZERO) } else { bounds })
}

/// The box around no points.
const NOTHING: (DVec3, DVec3) = (DVec3::INFINITY, DVec3::NEG_INFINITY);

/// Triangles that are worth handing to another thread.
const MIN_TRIANGLES: usize = 4096;

fn around(a: (DVec3, DVec3), b: (DVec3, DVec3)) -> (DVec3, DVec3) {
    (a.0.min(b.0), a.1.max(b.1))
}

fn check_mesh(index: usize, mesh: &Mesh) -> Result<(), GeometryError> {
    let vertices = mesh.positions.len();
    if mesh.triangles.len() > u32::MAX as usize {
        return Err(GeometryError::TooMany { what: "triangles", count: mesh.triangles.len() });
    }
    if let Some(vertex) = mesh.positions.par_iter().position_first(|p| !in_range(*p)) {
        return Err(GeometryError::Position { mesh: index, vertex });
    }
    let outside = |vertex: &u32| *vertex as usize >= vertices;
    if let Some(triangle) = mesh.triangles.par_iter().position_first(|corners| corners.iter().any(outside)) {
        let vertex = mesh.triangles[triangle].into_iter().find(outside).unwrap_or_default();
        return Err(GeometryError::VertexIndex { mesh: index, triangle, vertex, vertices });
    }
    let lengths = [
        ("normals", mesh.normals.as_ref().map(Vec::len)),
        ("tangents", mesh.tangents.as_ref().map(Vec::len)),
        ("first texture coordinates", mesh.texcoords[0].as_ref().map(Vec::len)),
        ("second texture coordinates", mesh.texcoords[1].as_ref().map(Vec::len)),
        ("colors", mesh.colors.as_ref().map(Vec::len)),
    ];
    for (attribute, length) in lengths {
        if let Some(found) = length.filter(|length| *length != vertices) {
            return Err(GeometryError::AttributeLength { mesh: index, attribute, found, vertices });
        }
    }
    Ok(())
}
