// SPDX-License-Identifier: MIT
#include "compare/metrics/agreement.h"

#include <cassert>
#include <cmath>
#include <vector>

#include "compare/metrics/pixel_sums.h"

namespace alidade::compare {
namespace {

double sigma_at(const ComparedImage& image, std::size_t pixel) {
  if (image.depth_sigma.empty()) return 0.0;
  const float sigma = image.depth_sigma[pixel];
  return sigma > 0.0f ? static_cast<double>(sigma) : 0.0;
}

bool is_scan(const ComparedImage& image) {
  if (image.depth_sigma.empty()) return false;
  bool has_depth = false;
  for (std::size_t pixel = 0; pixel < image.pixels(); ++pixel) {
    if (!is_depth(image.depth[pixel])) continue;
    if (sigma_at(image, pixel) > 0.0) return true;
    has_depth = true;
  }
  return !has_depth;
}

/// The agreement of a pixel where `image` has a depth and the other image has none.
Agreement one_sided(const ComparedImage& image, std::size_t pixel, bool other_is_scan) {
  if (std::isinf(sigma_at(image, pixel))) return Agreement::agrees;
  return other_is_scan ? Agreement::not_scanned : Agreement::differs;
}

struct AgreementSums : AgreementMetrics {
  void add(const AgreementSums& later) {
    agreeing += later.agreeing;
    differing += later.differing;
    not_scanned += later.not_scanned;
  }

  void add(Agreement agreement) {
    agreeing += agreement == Agreement::agrees ? 1 : 0;
    differing += agreement == Agreement::differs ? 1 : 0;
    not_scanned += agreement == Agreement::not_scanned ? 1 : 0;
  }
};

}  // namespace

DepthAgreement::DepthAgreement(const ComparedImage& reference, const ComparedImage& test)
    : reference_(reference),
      test_(test),
      reference_is_scan_(is_scan(reference)),
      test_is_scan_(is_scan(test)) {
  assert(reference.depth.size() == reference.pixels() && test.depth.size() == reference.pixels());
}

Agreement DepthAgreement::at(std::size_t pixel) const {
  const float from = reference_.depth[pixel], to = test_.depth[pixel];
  if (!is_depth(from)) return is_depth(to) ? one_sided(test_, pixel, reference_is_scan_) : Agreement::nothing;
  if (!is_depth(to)) return one_sided(reference_, pixel, test_is_scan_);
  const double one = sigma_at(reference_, pixel), other = sigma_at(test_, pixel);
  const double limit = 3.0 * std::sqrt(one * one + other * other);
  const double apart = std::fabs(static_cast<double>(to) - static_cast<double>(from));
  return apart <= limit ? Agreement::agrees : Agreement::differs;
}

bool have_agreement(const ComparedImage& reference, const ComparedImage& test) {
  return !reference.depth.empty() && !test.depth.empty() &&
         (!reference.depth_sigma.empty() || !test.depth_sigma.empty());
}

std::optional<AgreementMetrics> agreement_metrics(const ComparedImage& reference, const ComparedImage& test,
                                                  const ImageMask& mask) {
  if (!have_agreement(reference, test)) return {};
  const DepthAgreement agreement(reference, test);
  const auto width = static_cast<std::size_t>(reference.width);
  return sum_rows<AgreementSums>(static_cast<std::size_t>(reference.height),
                                 [&](std::size_t y, AgreementSums& sums) {
                                   for (std::size_t pixel = y * width; pixel < (y + 1) * width; ++pixel)
                                     if (mask.at(pixel)) sums.add(agreement.at(pixel));
                                 });
}

}  // namespace alidade::compare
