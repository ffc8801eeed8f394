//! Words of files and users, made fit for a terminal: what they contain must not steer it, nor look like something else.

use std::borrow::Cow;

/// Characters that turn the direction of writing, join lines or cannot be seen, but for joiners, without which Persian, Hindi and
/// families of emoji are not what they are. "Trojan Source" (Boucher and Anderson 2021) shows what they hide.
fn is_hidden(c: char) -> bool {
    matches!(c, '\u{ad}' | '\u{61c}' | '\u{200b}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}

/// `text` with an escape, `\u001b`, for each character that does more than to be shown. In JSON and TOML it has the same meaning.
fn escaped(text: &str, stays: impl Fn(char) -> bool) -> Cow<'_, str> {
    let is_odd = |c: char| (c.is_control() || is_hidden(c)) && !stays(c);
    if !text.contains(is_odd) {
        return Cow::Borrowed(text);
    }
    let one = |c: char| if is_odd(c) { format!("\\u{:04x}", u32::from(c)) } else { c.to_string() };
    Cow::Owned(text.chars().map(one).collect())
}

/// Words that somebody else chose, in one line whatever is in them.
///
/// ```
/// assert_eq!(taffeta_io::program::one_line("a\n\u{1b}[2Jb"), "a\\u000a\\u001b[2Jb");
/// ```
pub fn one_line(text: &str) -> Cow<'_, str> {
    escaped(text, |_| false)
}

/// As [`one_line`], for text of several lines.
pub(super) fn lines(text: &str) -> Cow<'_, str> {
    escaped(text, |c| matches!(c, '\n' | '\t'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_steers_a_terminal_or_hides_words_is_left() {
        for (odd, shown) in [
            ("\u{1b}]0;title\u{7}", "\\u001b]0;title\\u0007"),
            ("\u{9b}31m", "\\u009b31m"),
            ("a\rb", "a\\u000db"),
            ("\u{202e}lmth\u{2066}", "\\u202elmth\\u2066"),
            ("zero\u{200b}width", "zero\\u200bwidth"),
        ] {
            assert_eq!((lines(odd), one_line(odd)), (shown.into(), shown.into()));
        }
        assert_eq!((lines("a\n\tb"), one_line("a\n\tb")), ("a\n\tb".into(), "a\\u000a\\u0009b".into()));
        for plain in
            ["Stoff über Körper, 織物, قماش 🧵", "👨\u{200d}👩\u{200d}👧 می\u{200c}خواهم", "`x` = [1, 2]"]
        {
            assert!(matches!(lines(plain), Cow::Borrowed(_)));
        }
    }

    #[test]
    fn escapes_mean_the_same_in_json_and_toml() {
        let odd = "\u{1b}[2J\u{202e}";
        let json = lines(&serde_json::to_string(odd).unwrap()).into_owned();
        assert_eq!(serde_json::from_str::<String>(&json).unwrap(), odd);
        let toml: toml::Table = lines(&format!("title = \"{}\"", one_line(odd))).parse().unwrap();
        assert_eq!(toml["title"].as_str(), Some(odd));
    }
}
