//! What stands in the registries.

use super::*;

#[test]
fn records_are_complete() {
    let mut names = BTreeSet::new();
    for entry in QUANTITIES.iter() {
        let info = entry.info;
        for (what, text) in [
            ("name", info.name),
            ("symbol", info.symbol),
            ("unit", info.unit),
            ("formula", info.formula),
            ("source", info.source),
            ("limits", info.limits),
            ("meaning", info.meaning),
        ] {
            assert!(!text.trim().is_empty(), "{} has no {what}", info.name);
        }
        assert!(names.insert(info.name), "{} stands twice", info.name);
        let unique: BTreeSet<_> = info.params.iter().collect();
        assert_eq!(unique.len(), info.params.len(), "{} names a parameter twice", info.name);
        assert!(!info.params.is_empty());
        for id in ParamId::all() {
            assert_eq!(entry.uses(id), info.params.contains(&id.param().name));
        }
        assert!(std::ptr::eq(Entry::parse(info.name).unwrap(), entry));
    }
    for id in ParamId::all() {
        let param = id.param();
        assert!(names.insert(param.name), "{} is a name of two things", param.name);
        assert!(!param.meaning.is_empty() && !param.symbol.is_empty() && !param.unit.is_empty());
        assert_eq!(ParamId::parse(param.name), Ok(id));
        assert!(param.range.0 < param.range.1);
        assert!(param.default.is_none_or(|v| param.allows(v)), "{}: default", param.name);
        assert_eq!(param.name.ends_with("_deg"), param.unit == "deg");
        let used = QUANTITIES.iter().any(|entry| entry.uses(id))
            || LAWS.iter().any(|law| law.info.params.contains(&param.name))
            || DriveKind::ALL.iter().any(|drive| drive.info().params.contains(&param.name));
        assert!(used, "nothing takes {}", param.name);
    }
    let mut codes = BTreeSet::new();
    for status in Status::ALL {
        assert!(codes.insert(*status as u8) && names.insert(status.name()));
        assert!(!status.sentence().is_empty());
    }
}

#[test]
fn formulas_are_balanced() {
    let balanced = |text: &str, open: &str, close: &str| {
        let mut depth = 0i32;
        let mut rest = text;
        while !rest.is_empty() {
            if let Some(after) = rest.strip_prefix(open) {
                (depth, rest) = (depth + 1, after);
            } else if let Some(after) = rest.strip_prefix(close) {
                (depth, rest) = (depth - 1, after);
            } else {
                rest = &rest[rest.chars().next().map_or(1, char::len_utf8)..];
            }
            if depth < 0 {
                return false;
            }
        }
        depth == 0
    };
    let texts = QUANTITIES
        .iter()
        .flat_map(|e| [e.info.formula, e.info.symbol])
        .chain(PARAMS.iter().map(|p| p.symbol))
        .chain(DriveKind::ALL.iter().map(|d| d.info().formula))
        .chain(EFFECTS.iter().map(|e| e.formula))
        .chain(LAWS.iter().map(|l| l.info.formula));
    for text in texts {
        assert!(balanced(text, "{", "}"), "{text}");
        assert!(balanced(text, r"\left", r"\right"), "{text}");
        assert!(balanced(text, "(", ")"), "{text}");
        assert!(!text.contains('$') && !text.contains("  "), "{text}");
    }
    assert!(!balanced("}{", "{", "}") && !balanced("{{}", "{", "}"), "the check sees nothing");
}
