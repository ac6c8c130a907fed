//! Progress bars on a terminal.

use std::time::Duration;

use dcb_formats::threads::one_more;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Where progress goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Display {
    /// Bars on standard error.
    Bars,
    /// Nowhere.
    Silent,
}

/// A bar of so many steps, in the form of the template.
pub fn bar(display: Display, steps: u64, template: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(
        Some(steps),
        match display {
            Display::Bars => ProgressDrawTarget::stderr(),
            Display::Silent => ProgressDrawTarget::hidden(),
        },
    );
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

/// Lets a bar that is shown go on while nothing is told, where the system allows a thread for that.
pub fn tick(bar: &ProgressBar) {
    // The bar takes its thread for granted.
    if !bar.is_hidden() && one_more() {
        bar.enable_steady_tick(Duration::from_millis(200));
    }
}
