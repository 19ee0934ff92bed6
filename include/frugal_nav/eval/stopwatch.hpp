#pragma once

namespace frugal_nav::eval {

/// Wall time since an arbitrary instant [ms], for what a suite reports as its own speed; the only clock of
/// the libraries, and nothing may be decided by it.
double wallTime_ms();

}  // namespace frugal_nav::eval
