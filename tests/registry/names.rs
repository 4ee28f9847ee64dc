//! Hints for unknown names.

use super::*;

#[test]
fn unknown_names_get_a_hint() {
    let error = Entry::parse("mean_velocty").err().unwrap().to_string();
    assert!(error.contains("mean_velocty") && error.contains("did you mean 'mean_velocity'"));
    let error = ParamId::parse("mu_statc").unwrap_err().to_string();
    assert!(error.contains("'mu_static'"), "{error}");
    let error = Reduce::parse("agmax", None).unwrap_err().to_string();
    assert!(error.contains("'argmax'"), "{error}");
    let error = Entry::parse("Ω").err().unwrap().to_string();
    assert!(error.contains("known are") && error.contains("anchor_capacity"), "{error}");
}
