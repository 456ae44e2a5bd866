// SPDX-License-Identifier: MIT
#include "camera/polynomial.h"

#include <algorithm>

namespace alidade {

double value_at(const Polynomial& polynomial, double x) {
  double value = 0.0;
  for (auto each = polynomial.rbegin(); each != polynomial.rend(); ++each) value = value * x + *each;
  return value;
}

Polynomial derivative(const Polynomial& polynomial) {
  Polynomial result;
  for (std::size_t i = 1; i < polynomial.size(); ++i)
    result.push_back(static_cast<double>(i) * polynomial[i]);
  return result;
}

Polynomial product(const Polynomial& a, const Polynomial& b) {
  Polynomial result(a.empty() || b.empty() ? 0 : a.size() + b.size() - 1);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) result[i + j] += a[i] * b[j];
  }
  return result;
}

Polynomial difference(const Polynomial& a, const Polynomial& b) {
  Polynomial result(std::max(a.size(), b.size()));
  std::copy(a.begin(), a.end(), result.begin());
  for (std::size_t i = 0; i < b.size(); ++i) result[i] -= b[i];
  return result;
}

std::vector<double> sign_changes(const Polynomial& polynomial, double end) {
  if (polynomial.size() < 2) return {};
  // Between two places where the derivative changes its sign the polynomial is monotone.
  std::vector<double> borders = sign_changes(derivative(polynomial), end);
  borders.push_back(end);
  std::vector<double> changes;
  double low = 0.0;
  for (const double border : borders) {
    double high = border;
    const bool below = value_at(polynomial, low) < 0.0;
    if (below != (value_at(polynomial, high) < 0.0)) {
      for (double middle = 0.5 * (low + high); low < middle && middle < high; middle = 0.5 * (low + high))
        ((value_at(polynomial, middle) < 0.0) == below ? low : high) = middle;
      changes.push_back(low);
    }
    low = border;
  }
  return changes;
}

}  // namespace alidade
