//! Patterns of path classes, in a part of Heckbert's notation (Heckbert 1990): `LS+DE`, `LD*E`, `L.*SDE`.

/// What a place of a pattern stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Item {
    /// One of L, D, S, E, or a full stop for D or S.
    letter: u8,
    /// Whether it may be missing.
    optional: bool,
    /// Whether it may be there several times.
    repeated: bool,
}

/// A pattern of path classes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClassPattern {
    items: Vec<Item>,
}

impl ClassPattern {
    /// Reads a pattern.
    ///
    /// # Errors
    ///
    /// A sentence that says what is wrong.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut items: Vec<Item> = Vec::new();
        for letter in text.bytes() {
            match (letter, items.last_mut()) {
                (b'*' | b'+' | b'?', Some(item)) if !item.optional && !item.repeated => {
                    item.optional = letter != b'+';
                    item.repeated = letter != b'?';
                }
                (b'L' | b'D' | b'S' | b'E' | b'.', _) => items.push(Item { letter, optional: false, repeated: false }),
                _ => return Err("give a class like LSDE, from L through letters D, S or . with *, + or ? to E".into()),
            }
        }
        let plain = |item: Option<&Item>, letter: u8| item.is_some_and(|item| item.letter == letter && !item.optional);
        let inner = items.len() >= 2 && items[1..items.len() - 1].iter().all(|item| !b"LE".contains(&item.letter));
        if plain(items.first(), b'L') && plain(items.last(), b'E') && inner {
            Ok(Self { items })
        } else {
            Err(format!("{text} does not go from the light L to the eye E; give a class like LSDE or 'LS+DE'"))
        }
    }

    /// Whether a class, such as `LSDE`, is of this kind.
    pub fn matches(&self, class: &str) -> bool {
        // Which numbers of letters the items so far can stand for.
        let letters = class.as_bytes();
        let mut reached = vec![false; letters.len() + 1];
        reached[0] = true;
        for item in &self.items {
            let fits = |letter: u8| letter == item.letter || item.letter == b'.' && b"DS".contains(&letter);
            let mut next = if item.optional { reached.clone() } else { vec![false; reached.len()] };
            for i in 0..letters.len() {
                next[i + 1] |= fits(letters[i]) && (reached[i] || item.repeated && next[i]);
            }
            reached = next;
        }
        reached[letters.len()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_match_as_regular_expressions_do() {
        let all = ["LE", "LDE", "LSE", "LDDE", "LDSE", "LSDE", "LSSE", "LSSDE", "LSDSE", "LDSDE", "LDDDE"];
        let matching = |pattern: &str| {
            let pattern = ClassPattern::parse(pattern).unwrap();
            all.into_iter().filter(|class| pattern.matches(class)).collect::<Vec<_>>()
        };
        assert_eq!(matching("LSDE"), ["LSDE"]);
        assert_eq!(matching("LS+DE"), ["LSDE", "LSSDE"]);
        assert_eq!(matching("LD*E"), ["LE", "LDE", "LDDE", "LDDDE"]);
        assert_eq!(matching("LD*D?E"), ["LE", "LDE", "LDDE", "LDDDE"]);
        assert_eq!(matching("L.*SDE"), ["LSDE", "LSSDE", "LDSDE"]);
        assert_eq!(matching("L..E"), ["LDDE", "LDSE", "LSDE", "LSSE"]);
        assert_eq!(matching("LS*D*E").len(), 8);
    }

    #[test]
    fn what_is_no_class_is_told() {
        for wrong in ["", "L", "E", "LSD", "SDE", "LXE", "L*", "L*E", "LD**E", "*E", "LLE", "ldE"] {
            assert!(ClassPattern::parse(wrong).unwrap_err().contains("LSDE"), "{wrong}");
        }
    }
}
