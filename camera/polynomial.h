// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace alidade {

/// Coefficients, that of x^0 first.
using Polynomial = std::vector<double>;

double value_at(const Polynomial& polynomial, double x);
Polynomial derivative(const Polynomial& polynomial);
Polynomial product(const Polynomial& a, const Polynomial& b);
Polynomial difference(const Polynomial& a, const Polynomial& b);

/// The last places before the polynomial changes its sign in (0, end], ascending, to the last bit. Places
/// where it only touches zero are left out. The same bits on every machine.
std::vector<double> sign_changes(const Polynomial& polynomial, double end);

}  // namespace alidade
