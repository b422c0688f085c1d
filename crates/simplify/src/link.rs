//! Whether merging the ends of an edge would change the topology: the link condition of complexes (`dey1999`), where an edge
//! with other than two triangles counts as a rim.

/// The surroundings of two vertices u and v, of each in this order.
pub(crate) struct Link<'a> {
    pub pair: [u32; 2],
    /// Triangles of one alone: (triangle, after, before).
    pub stay: [&'a [(u32, u32, u32)]; 2],
    /// Triangles on the edge: (triangle, third corner, whether it reads (v, w, u)).
    pub shared: &'a [(u32, u32, bool)],
    /// Neighbours, with the number of triangles on the edge to them.
    pub near: [&'a [(u32, u32)]; 2],
    /// Whether fans meet there that share no edge.
    pub ties: [bool; 2],
}

impl Link<'_> {
    /// `None` where merging would change the topology; else whether the merged vertex lies on a rim.
    #[inline]
    pub fn merges(&self) -> Option<bool> {
        let Link { pair: [_, v], stay: [stay_u, stay_v], shared, near: [near_u, near_v], ties: [tie_u, tie_v] } = *self;
        if shared.is_empty() || stay_u.len() + stay_v.len() == 0 {
            return None;
        }
        let is_third = |x: u32| shared.iter().any(|&(_, w, _)| w == x);
        for (i, &(_, w, _)) in shared.iter().enumerate() {
            if shared[..i].iter().any(|&(_, other, _)| other == w) {
                return None; // two triangles with the same corners
            }
            if uses(near_u, w) != 2 && uses(near_v, w) != 2 {
                return None; // two rims would become one
            }
        }
        for &(x, _) in near_u.iter() {
            if x != v && uses(near_v, x) > 0 && !is_third(x) {
                return None; // a cycle of three edges without a triangle would close
            }
        }
        for &(_, a, b) in stay_u.iter() {
            if is_third(a) && is_third(b) && stay_v.iter().any(|&(_, c, d)| (c, d) == (a, b) || (c, d) == (b, a)) {
                return None; // two triangles would become one
            }
        }
        let rims = |near: &[(u32, u32)]| near.iter().filter(|(_, n)| *n != 2).count();
        let (rims_u, rims_v) = (rims(near_u), rims(near_v));
        if (rims_u > 0 || tie_u) && (rims_v > 0 || tie_v) {
            // A curve goes on through a vertex where its two edges have equally many triangles; else it ends there.
            let end = |near: &[(u32, u32)], tie: bool| {
                let mut rims = near.iter().map(|&(_, n)| n).filter(|&n| n != 2);
                tie || rims.next().is_some_and(|first| rims.next() != Some(first) || rims.next().is_some())
            };
            if shared.len() == 2 || (end(near_u, tie_u) && end(near_v, tie_v)) {
                return None; // two rims would touch, or two of their ends
            }
        }
        Some(rims_u + rims_v > 0)
    }
}

/// Counts the other corners of a triangle among a vertex's neighbours.
#[inline]
pub(crate) fn count_neighbours(near: &mut Vec<(u32, u32)>, triangle: (u32, u32)) {
    for x in <[u32; 2]>::from(triangle) {
        match near.iter_mut().find(|(y, _)| *y == x) {
            Some((_, n)) => *n += 1,
            None => near.push((x, 1)),
        }
    }
}

/// Number of triangles on the edge to a neighbour.
#[inline]
pub(crate) fn uses(near: &[(u32, u32)], x: u32) -> u32 {
    near.iter().find(|(y, _)| *y == x).map_or(0, |(_, n)| *n)
}

/// Into how many connected fans the edges opposite to a vertex fall.
pub(crate) fn fans(edges: &mut Vec<[u32; 2]>) -> usize {
    let mut fans = 0;
    let mut frontier = vec![];
    while let Some(first) = edges.pop() {
        fans += 1;
        frontier.extend(first);
        while let Some(x) = frontier.pop() {
            edges.retain(|e| {
                let meets = e.contains(&x);
                if meets {
                    frontier.extend(e);
                }
                !meets
            });
        }
    }
    fans
}
