#pragma once

#include <optional>
#include <sstream>
#include <string>

#include "formats/pixel.h"
#include "scenario/fault_keys.h"
#include "scenario/names.h"
#include "scenario/scenario.h"
#include "scenario/scenario_keys.h"

namespace metabuffer::test {

/// Notes the first of several comparisons that fails.
class FirstDifference {
  public:
    template <typename Value>
    void compare(const std::string& what, const Value& left, const Value& right) {
        if (left == right || !text_.empty()) return;
        std::ostringstream text;
        text << what << ": " << left << " and " << right;
        text_ = text.str();
    }
    void require(const std::string& what, bool holds) {
        if (!holds && text_.empty()) text_ = what;
    }
    const std::string& text() const { return text_; }

  private:
    std::string text_;
};

/// Whether two images give the same memory words once they have come over a link of that format.
inline bool same_pixels(const PixelImage& left, const PixelImage& right, DepthFormat format) {
    if (left.width_pixels != right.width_pixels || left.height_pixels != right.height_pixels) return false;
    for (std::size_t i = 0; i < left.values.size(); ++i) {
        const auto word = [format](Pixel pixel) {
            return with_depth_half(pixel, depth_link_bits(pixel, format), format);
        };
        if (word(left.values[i]) != word(right.values[i])) return false;
    }
    return true;
}

inline std::string text_of(const std::optional<KeyValue>& value) {
    return value ? value_text(*value) : std::string("none");
}

/// Why two scenarios are different machines or different input of one, empty if they are not. The position of a table
/// in a file does not count, nor do images that no frame uses.
inline std::string scenario_difference(const Scenario& left, const Scenario& right) {
    FirstDifference first;
    for (const ObjectKey<Scenario>& key : setting_rows()) {
        if (key.value == nullptr) continue;
        first.compare(key.schema.pattern, text_of(key.value(left)), text_of(key.value(right)));
    }
    first.require("corrected displays", left.displays.corrected() == right.displays.corrected());
    if (!first.text().empty()) return first.text();
    for (const int display : left.displays.corrected()) {
        first.require("colour table of display " + std::to_string(display),
                      *left.displays.colour_table_of(display) == *right.displays.colour_table_of(display));
    }
    first.compare("renderers", left.renderers.size(), right.renderers.size());
    first.compare("faults", left.faults.size(), right.faults.size());
    if (!first.text().empty()) return first.text();

    for (std::size_t r = 0; r < left.renderers.size(); ++r) {
        const Renderer& one = left.renderers[r];
        const Renderer& other = right.renderers[r];
        const std::string renderer = "renderer " + std::to_string(r);
        first.compare(renderer + " name", one.name, other.name);
        first.compare(renderer + " image width", one.image_width_pixels, other.image_width_pixels);
        first.compare(renderer + " image height", one.image_height_pixels, other.image_height_pixels);
        first.compare(renderer + " frames", one.frames.size(), other.frames.size());
        if (!first.text().empty()) return first.text();
        for (std::size_t f = 0; f < one.frames.size(); ++f) {
            const RendererFrame& frame = one.frames[f];
            const RendererFrame& other_frame = other.frames[f];
            const std::string where = renderer + " frame " + std::to_string(f);
            first.require(where + " table", frame.table == other_frame.table);
            first.compare(where + " controls", frame.controls.has_value(), other_frame.controls.has_value());
            if (frame.controls && other_frame.controls) {
                first.require(where + " controls", frame.controls->colour == other_frame.controls->colour &&
                                                       frame.controls->depth == other_frame.controls->depth);
            }
            first.compare(where + " viewport", frame.viewport.has_value(), other_frame.viewport.has_value());
            if (frame.viewport && other_frame.viewport) {
                for (const ObjectKey<Viewport>& key : viewport_rows()) {
                    first.compare(where + " " + key.schema.pattern, value_text(*key.value(*frame.viewport)),
                                  value_text(*key.value(*other_frame.viewport)));
                }
            }
            const auto pair = static_cast<std::uint32_t>(f);
            first.require(where + " image",
                          same_pixels(one.image_of_pair(pair), other.image_of_pair(pair), left.depth_format));
        }
    }
    for (std::size_t f = 0; f < left.faults.size(); ++f) {
        const Fault& one = left.faults[f];
        const Fault& other = right.faults[f];
        const std::string fault = "fault " + std::to_string(f);
        first.compare(fault + " renderer", one.renderer, other.renderer);
        first.compare(fault + " kind", to_string(one.kind), to_string(other.kind));
        for (const FaultKey& key : fault_keys()) {
            const auto text = [&key](const Fault& of) {
                const std::optional<KeyValue> value = key.value(of);
                return value ? value_text(*value) : std::string("none");
            };
            first.compare(fault + " " + key.name(), text(one), text(other));
        }
    }
    return first.text();
}

}  // namespace metabuffer::test
