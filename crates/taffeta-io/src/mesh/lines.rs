//! Lines of text, which end with `\n`, `\r\n` or `\r`.

/// Takes a line off `rest`, without its end and the spaces before that.
pub(super) fn next_line<'a>(rest: &mut &'a [u8]) -> &'a [u8] {
    let end = rest.iter().position(is_end).unwrap_or(rest.len());
    let (line, after) = rest.split_at(end);
    *rest = match after {
        [b'\r', b'\n', after @ ..] | [_, after @ ..] => after,
        [] => after,
    };
    line.trim_ascii_end()
}

/// Number of line ends in `text`, which does not end between `\r` and `\n`.
pub(super) fn line_ends(text: &[u8]) -> usize {
    let feeds = text.iter().filter(|&&b| b == b'\n').count();
    let returns = text.iter().filter(|&&b| b == b'\r').count();
    let both = text.windows(2).filter(|pair| pair == b"\r\n").count();
    feeds + returns - both
}

/// Whether a byte is the start of a line's end.
pub(super) fn is_end(byte: &u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_three_kinds_are_counted_as_they_are_taken_off() {
        for text in ["", "a", "a\n", "a\r", "a\r\n", "a \r\rb\n\n\r\nc\n\r", "\r", "\n\r\n"] {
            let (mut rest, mut lines) = (text.as_bytes(), Vec::new());
            while !rest.is_empty() {
                lines.push(next_line(&mut rest));
            }
            let open = usize::from(text.ends_with(|c: char| c.is_alphabetic()));
            assert_eq!(line_ends(text.as_bytes()) + open, lines.len(), "{text:?}");
            assert!(lines.iter().all(|line| matches!(line, [] | [b'a'..=b'c'])), "{text:?}");
        }
    }
}
