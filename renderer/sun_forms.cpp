// SPDX-License-Identifier: MIT
#include "renderer/sun_forms.h"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.h"

namespace alidade::renderer {
namespace {

/// What the sun is given by.
using GivenSun = std::variant<geo::Sun, geo::SunByTime>;

JsonForm<Moment> moment_form() {
  return {[](const JsonNode& node) {
            try {
              return parse_date_time(node.text());
            } catch (const Error& error) {
              const Error::Parts& parts = error.parts();
              // An Error of the node itself has its file and location already.
              if (!parts.file.empty()) throw;
              node.fail(parts.problem, parts.expected, parts.found);
            }
          },
          [](const Moment& moment) { return Json(date_time_text(moment)); },
          {{"type", "string"},
           {"pattern",
            "^(1[6-9]|2[0-9])[0-9]{2}-(0[1-9]|1[0-2])-(0[1-9]|[12][0-9]|3[01])T([01][0-9]|2[0-3]):[0-5][0-9]"
            "(:[0-5][0-9]([.][0-9]{1,9})?)?(Z|[+-]([01][0-9]|2[0-3]):[0-5][0-9])$"}}};
}

template <class Struct>
JsonKey<Struct> diameter_key() {
  return key<Struct>("angular_diameter", &Struct::angular_diameter, number_form({0, 180, false, true}),
                     "degrees; 0 is parallel light with hard shadows");
}

JsonKeys<geo::Sun> sun_keys() {
  using geo::Sun;
  return {key<Sun>("azimuth", &Sun::azimuth, number_form(k_angle),
                   "degrees, clockwise from north (+y): 90 is east (+x)"),
          key<Sun>("elevation", &Sun::elevation, number_form({-90, 90, true}), "degrees above the horizon"),
          key<Sun>("irradiance", &Sun::irradiance, rgb_form(k_light), "on a surface that faces the sun"),
          diameter_key<Sun>()};
}

JsonKeys<geo::SunByTime> sun_by_time_keys() {
  using geo::SunByTime;
  return {
      key<SunByTime>(
          "date_time", &SunByTime::moment, moment_form(),
          "with its time zone: 2003-10-17T12:30:30-07:00 or 2003-10-17T19:30:30Z, in the years 1600 to 2999")
          .required(),
      key<SunByTime>("latitude", &SunByTime::latitude, number_form({-90, 90}),
                     "degrees north; left out, as longitude: that of the cloud, from its reference system"),
      key<SunByTime>("longitude", &SunByTime::longitude, number_form({-180, 180}), "degrees east"),
      key<SunByTime>("height", &SunByTime::height, number_form({-1000, 100000}), "metres above sea level"),
      key<SunByTime>("pressure", &SunByTime::pressure, number_form({0, 2000}),
                     "air pressure at that height, hPa"),
      key<SunByTime>("temperature", &SunByTime::temperature, number_form({-150, 100}),
                     "air temperature, degrees Celsius"),
      key<SunByTime>(
          "irradiance", &SunByTime::irradiance, word_or("auto", rgb_form(k_light)),
          "on a surface that faces the sun; auto: that of a clear sky, which is dimmer and redder near the "
          "horizon"),
      diameter_key<SunByTime>()};
}

GivenSun read_sun(const JsonNode& node, const JsonKeys<geo::Sun>& keys,
                  const JsonKeys<geo::SunByTime>& keys_by_time) {
  std::vector<std::string_view> known = names_of(keys), names = names_of(keys_by_time);
  std::ranges::copy_if(names, std::back_inserter(known),
                       [&](std::string_view name) { return !std::ranges::count(known, name); });
  const JsonFields fields(node, known);
  if (!fields.find("date_time")) {
    for (const std::string_view name : {"latitude", "longitude", "height", "pressure", "temperature"})
      if (const auto found = fields.find(name))
        found->fail("the location of the sun requires a time", "\"date_time\"", "none");
    geo::Sun sun;
    read_keys(node, keys, known, sun);
    return sun;
  }
  for (const std::string_view name : {"azimuth", "elevation"})
    if (const auto found = fields.find(name))
      found->fail("the sun has both angles and a time",
                  "\"date_time\" alone, or \"azimuth\" and \"elevation\"");
  geo::SunByTime sun;
  read_keys(node, keys_by_time, known, sun);
  const auto latitude = fields.find("latitude"), longitude = fields.find("longitude");
  if (latitude.has_value() != longitude.has_value())
    (latitude ? *latitude : *longitude)
        .fail("incomplete location", "\"latitude\" and \"longitude\"", "one of them");
  return sun;
}

JsonForm<GivenSun> given_sun_form() {
  Json by_angles = object_schema("by its place in the sky", sun_keys(), geo::Sun());
  Json by_time = object_schema("by date, time and location", sun_by_time_keys(), geo::SunByTime());
  by_time["dependentRequired"] = {{"latitude", {"longitude"}}, {"longitude", {"latitude"}}};
  return {[keys = sun_keys(), keys_by_time = sun_by_time_keys()](const JsonNode& node) {
            return read_sun(node, keys, keys_by_time);
          },
          [keys = sun_keys(), keys_by_time = sun_by_time_keys()](const GivenSun& sun) {
            const auto* const given = std::get_if<geo::Sun>(&sun);
            return given ? write_keys(keys, *given) : write_keys(keys_by_time, std::get<geo::SunByTime>(sun));
          },
          {{"description", "a disc of even radiance, infinitely far away; left out: no sun"},
           {"oneOf", {std::move(by_angles), std::move(by_time)}}}};
}

}  // namespace

JsonKey<Scene> sun_key() {
  JsonForm<GivenSun> form = given_sun_form();
  return {"sun", form.schema,
          [read = form.read](const JsonNode& node, Scene& scene) {
            const GivenSun sun = read(node);
            if (const auto* by_angles = std::get_if<geo::Sun>(&sun))
              scene.sun = *by_angles;
            else
              scene.sun_by_time = std::get<geo::SunByTime>(sun);
          },
          [write = form.write](const Scene& scene) {
            if (scene.sun_by_time) return write(*scene.sun_by_time);
            return scene.sun ? write(*scene.sun) : Json();
          }};
}

const JsonForm<geo::Sun>& sun_form() {
  static const JsonForm<geo::Sun> form = object_form<geo::Sun>("", sun_keys());
  return form;
}

}  // namespace alidade::renderer
