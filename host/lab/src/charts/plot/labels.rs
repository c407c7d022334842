//! Where texts find room: notes beside their points, legend entries broken into lines.

/// A rectangle \[px\], y downwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rect {
    pub left: i32,
    pub top: i32,
    pub width: i32,
    pub height: i32,
}

impl Rect {
    /// The square of half width `radius` around a place.
    fn around((x, y): (i32, i32), radius: i32) -> Self {
        Self { left: x - radius, top: y - radius, width: 2 * radius, height: 2 * radius }
    }

    pub fn right(&self) -> i32 {
        self.left + self.width
    }

    pub fn bottom(&self) -> i32 {
        self.top + self.height
    }

    fn overlap(&self, other: &Self) -> i64 {
        let along = |a: i32, a_long: i32, b: i32, b_long: i32| {
            i64::from(((a + a_long).min(b + b_long) - a.max(b)).max(0))
        };
        along(self.left, self.width, other.left, other.width)
            * along(self.top, self.height, other.top, other.height)
    }

    #[cfg(test)]
    fn area(&self) -> i64 {
        i64::from(self.width) * i64::from(self.height)
    }
}

/// Distance from a point to its note \[px\], and how many wider ones are tried.
const GAP: i32 = 20;
const RINGS: i32 = 8;
/// Half the side of the square that a marker takes, and the width of a line's trace \[px\].
const MARKER: i32 = 18;
const LINE: i32 = 8;
/// No text touches the frame \[px\].
const AIR: i32 = 8;

/// The places taken within a frame.
pub(super) struct Room {
    frame: Rect,
    taken: Vec<Rect>,
}

impl Room {
    pub fn new(frame: Rect) -> Self {
        let (left, top) = (frame.left + AIR, frame.top + AIR);
        let (width, height) = (frame.width - 2 * AIR, frame.height - 2 * AIR);
        let frame = Rect { left, top, width, height };
        Self { frame, taken: Vec::new() }
    }

    /// Nothing else shall stand here.
    fn take(&mut self, rect: Rect) {
        self.taken.push(rect);
    }

    /// Nothing shall stand on these points, nor on the `joined` line through them.
    pub fn take_path(&mut self, points: &[(i32, i32)], joined: bool) {
        points.iter().for_each(|&point| self.take(Rect::around(point, MARKER)));
        for pair in points.windows(2).filter(|_| joined) {
            let ((x, y), (to_x, to_y)) = (pair[0], pair[1]);
            let parts = (to_x - x).abs().max((to_y - y).abs()) / LINE;
            for part in 1..parts {
                let at = |from: i32, to: i32| from + (to - from) * part / parts;
                self.take(Rect::around((at(x, to_x), at(y, to_y)), LINE / 2));
            }
        }
    }

    /// Takes the place near one of the points `near` where a text of that size covers least of
    /// what is taken; inside the frame where the text fits in at all.
    pub fn place(&mut self, near: &[(i32, i32)], (width, height): (i32, i32)) -> Rect {
        let mut best = (i64::MAX, Rect { left: 0, top: 0, width, height });
        let rings = (0..RINGS).map(|ring| GAP + ring * GAP / 2);
        for (gap, &(x, y)) in rings.flat_map(|gap| near.iter().map(move |point| (gap, point))) {
            let (right, left) = (x + gap, x - gap - width);
            let (above, below, beside) = (y - gap - height, y + gap, y - height / 2);
            let centred = x - width / 2;
            let places = [
                (right, above),
                (right, beside),
                (right, below),
                (centred, above),
                (centred, below),
                (left, above),
                (left, beside),
                (left, below),
            ];
            for (left, top) in places {
                let rect = self.inside(Rect { left, top, width, height });
                let covered = self.taken.iter().map(|taken| taken.overlap(&rect)).sum();
                if covered < best.0 {
                    best = (covered, rect);
                }
            }
        }
        self.take(best.1);
        best.1
    }

    fn inside(&self, rect: Rect) -> Rect {
        let fit = |at: i32, long: i32, from: i32, room: i32| at.min(from + room - long).max(from);
        let frame = self.frame;
        Rect {
            left: fit(rect.left, rect.width, frame.left, frame.width),
            top: fit(rect.top, rect.height, frame.top, frame.height),
            ..rect
        }
    }

    /// Whether a text that was placed covers nothing but itself.
    #[cfg(test)]
    fn is_free(&self, rect: &Rect) -> bool {
        self.taken.iter().map(|taken| taken.overlap(rect)).sum::<i64>() == rect.area()
    }
}

/// Breaks a text at its spaces into lines of at most `wide`, measured by `width_of`.
pub(super) fn wrap(text: &str, wide: i32, width_of: impl Fn(&str) -> i32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if width_of(&format!("{line} {word}")) <= wide => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_of_a_cluster_stand_apart_and_within_the_frame() {
        let frame = Rect { left: 0, top: 0, width: 600, height: 300 };
        let mut room = Room::new(frame);
        let points = [(590, 5), (570, 10), (595, 20), (300, 200), (310, 200)];
        points.iter().for_each(|&point| room.take_path(&[point], false));
        let placed: Vec<Rect> = points.map(|point| room.place(&[point], (60, 14))).to_vec();
        for rect in placed {
            assert_eq!(rect.overlap(&frame), rect.area(), "{rect:?} leaves the frame");
            assert!(room.is_free(&rect), "{rect:?} covers something");
        }
    }

    #[test]
    fn lines_break_at_spaces() {
        let width = |text: &str| text.len() as i32;
        assert_eq!(wrap("one two three", 7, width), ["one two", "three"]);
        assert_eq!(wrap("unbreakable", 3, width), ["unbreakable"]);
    }
}
