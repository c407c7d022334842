//! Pieces of a cut body that have come loose.
//!
//! Tetrahedra that share a cell are of one piece: a piece that hangs on one cell or on an edge alone is part of what
//! it hangs on. Cost: a look at each tetrahedron.

/// Pieces that hang on no fixed cell.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Loose {
    /// Number of pieces; of a body without fixed cells all but the largest one.
    pub pieces: u32,
    /// Number of their cells.
    pub cells: u32,
}

/// A piece.
#[derive(Clone, Copy, Default)]
struct Piece {
    cells: u32,
    is_fixed: bool,
}

impl Loose {
    /// The loose pieces of a body of `body` cells and copies with these origins, some cells fixed.
    #[must_use]
    pub fn of(
        tetrahedra: &[[u16; 4]],
        origins: &[u16],
        body: usize,
        is_fixed: impl Fn(u16) -> bool,
    ) -> Self {
        // Join the cells of each tetrahedron: each cell names a lower one of its piece, the lowest itself.
        let mut names: Vec<usize> = (0..body + origins.len()).collect();
        for corners in tetrahedra {
            let lowest = corners.map(|cell| lowest(&mut names, cell.into()));
            let first = lowest.into_iter().fold(usize::MAX, usize::min);
            lowest.iter().for_each(|&name| names[name] = first);
        }
        // Count the cells of each piece.
        let mut pieces = vec![Piece::default(); names.len()];
        for cell in 0..names.len() {
            let origin = cell.checked_sub(body).map_or(cell as u16, |copy| origins[copy]);
            let piece = &mut pieces[lowest(&mut names, cell)];
            piece.cells += 1;
            piece.is_fixed |= is_fixed(origin);
        }
        pieces.retain(|piece| piece.cells > 0);
        // A body that nothing fixes is its largest piece.
        if !pieces.iter().any(|piece| piece.is_fixed)
            && let Some(largest) = pieces.iter_mut().max_by_key(|piece| piece.cells)
        {
            largest.is_fixed = true;
        }
        let loose = pieces.iter().filter(|piece| !piece.is_fixed);
        let count =
            |of: Self, piece: &Piece| Self { pieces: of.pieces + 1, cells: of.cells + piece.cells };
        loose.fold(Self::default(), count)
    }
}

/// The lowest cell of a cell's piece, which is then named by all on the way.
fn lowest(names: &mut [usize], cell: usize) -> usize {
    let mut found = cell;
    while names[found] != found {
        found = names[found];
    }
    let mut at = cell;
    while names[at] != found {
        at = std::mem::replace(&mut names[at], found);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three tetrahedra in a row that share a cell each, from 0 to 9, the last with a copy in place of the shared one.
    const ROW: [[u16; 4]; 3] = [[3, 4, 5, 6], [0, 1, 2, 3], [10, 7, 8, 9]];

    #[test]
    fn pieces_without_a_fixed_cell_are_loose() {
        let of = |fixed: &[u16]| Loose::of(&ROW, &[6], 10, |cell| fixed.contains(&cell));
        assert_eq!(of(&[0]), Loose { pieces: 1, cells: 4 });
        assert_eq!(of(&[9]), Loose { pieces: 1, cells: 7 });
        // A copy of a fixed cell is fixed.
        assert_eq!(of(&[6]), Loose::default());
        // Without fixed cells the largest piece is the body.
        assert_eq!(of(&[]), Loose { pieces: 1, cells: 4 });
        assert_eq!(Loose::of(&ROW[..2], &[], 7, |_| false), Loose::default());
    }
}
