// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <utility>

#include "base/color.h"
#include "renderer/scene.h"
#include "simulation/site.h"

namespace alidade::jobs {

/// The exact surfaces of a site, instead of a scan of them, as part of a scene. Cost: about half a
/// microsecond per ray.
class SiteSurfaces final : public renderer::Surfaces {
 public:
  SiteSurfaces(simulation::Site site, std::string name) : site_(std::move(site)), name_(std::move(name)) {}

  std::optional<Hit> closest(const Ray& ray) const override {
    const std::optional<simulation::SiteHit> hit = site_.closest(ray);
    if (!hit) return std::nullopt;
    Rgb color;
    for (int channel = 0; channel < 3; ++channel)
      color[channel] = static_cast<float>(linear_from_srgb(hit->color[channel]));
    return Hit{.t = hit->t, .normal = hit->normal, .color = color};
  }
  Bounds bounds() const override { return site_.bounds(); }
  std::string name() const override { return name_; }

  const simulation::Site& site() const { return site_; }

 private:
  const simulation::Site site_;
  const std::string name_;
};

}  // namespace alidade::jobs
