//! A hemicube face by face: edges within faces, and seams between them.

use super::{Edge, Table};

/// Edges of a [`Table`] by faces.
pub struct Faces {
    /// Of each texel the edges to the left and to the upper one of its face.
    pub inner: Vec<[Option<Edge>; 2]>,
    /// Edges between faces.
    pub seams: Vec<Edge>,
    /// Of each texel that these touch its number among all such.
    pub border: Vec<Option<u32>>,
    /// How many these are.
    pub border_count: u32,
}

impl Faces {
    /// Those of `table`.
    pub fn of(table: &Table) -> Self {
        let mut faces = Self {
            inner: vec![[None; 2]; table.texels.len()],
            seams: Vec::new(),
            border: vec![None; table.texels.len()],
            border_count: 0,
        };
        for edge in &table.edges {
            let [a, b] = [edge.i, edge.j].map(|i| &table.texels[i as usize]);
            if a.layer == b.layer {
                // Texels come row by row: the first one of an edge is the one to the left or above.
                faces.inner[edge.j as usize][usize::from(a.x == b.x)] = Some(*edge);
            } else {
                faces.seams.push(*edge);
                faces.number(edge.i);
                faces.number(edge.j);
            }
        }
        faces
    }

    fn number(&mut self, texel: u32) {
        let number = &mut self.border[texel as usize];
        if number.is_none() {
            *number = Some(self.border_count);
            self.border_count += 1;
        }
    }
}
