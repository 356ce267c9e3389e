#include "report/report_difference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "formats/image_difference.h"
#include "host/text.h"

namespace metabuffer {

namespace {

using Json = nlohmann::ordered_json;

/// The names of a report's parts.
class PartNames {
  public:
    explicit PartNames(const Json& report) {
        const auto renderers = report.find("renderers");
        if (renderers == report.end() || !renderers->is_array()) return;
        for (const Json& renderer : *renderers) {
            const std::string name = text_at(renderer, "name");
            renderers_.push_back(name.empty() ? std::to_string(renderers_.size() + 1) : name);
        }
    }

    /// The text between the brackets for an entry of a list: the renderer or display that it belongs to if known, else
    /// its index.
    std::string entry(const std::string& list, const Json& value, std::size_t index) const {
        if (list == "renderers" && index < renderers_.size()) return renderers_[index];
        if (list == "pairs" && index < renderers_.size()) return "renderer " + renderers_[index];
        if (list == "displays") return number_at(value, "display").value_or(std::to_string(index + 1));
        if (list == "composers") {
            const std::optional<std::string> display = number_at(value, "display");
            const std::optional<std::string> renderer = number_at(value, "renderer");
            if (display && renderer) return "renderer " + renderer_name(*renderer) + ", display " + *display;
        }
        return std::to_string(index);
    }

  private:
    static std::string text_at(const Json& object, const char* key) {
        const auto found = object.is_object() ? object.find(key) : object.end();
        return found != object.end() && found->is_string() ? text::one_line(found->get<std::string>()) : "";
    }
    static std::optional<std::string> number_at(const Json& object, const char* key) {
        const auto found = object.is_object() ? object.find(key) : object.end();
        if (found == object.end() || !found->is_number_integer()) return std::nullopt;
        return std::to_string(found->get<std::int64_t>());
    }
    /// Composers know their renderer by its number, from 1.
    std::string renderer_name(const std::string& number) const {
        for (std::size_t i = 0; i < renderers_.size(); ++i) {
            if (std::to_string(i + 1) == number) return renderers_[i];
        }
        return number;
    }

    std::vector<std::string> renderers_;
};

/// One line of JSON; a report's texts may have any bytes.
std::string shown(const Json& value) { return value.dump(-1, ' ', false, Json::error_handler_t::replace); }

std::string member_path(const std::string& path, const std::string& key) {
    std::string result = path;
    if (!path.empty()) result += '.';
    return result += key;
}

bool is_texts(const Json& value) {
    return value.is_array() &&
           std::all_of(value.begin(), value.end(), [](const Json& item) { return item.is_string(); });
}

class Comparison {
  public:
    Comparison(const Json& left, const ComparedNames& names) : parts_(left), names_(names) {}

    void compare(const Json& left, const Json& right) { members("", left, right); }
    ReportComparison result() && { return std::move(result_); }

  private:
    /// `key` is the last one of the path.
    void values(const std::string& path, const std::string& key, const Json& left, const Json& right) {
        if (left.is_object() && right.is_object()) {
            members(path, left, right);
        } else if (is_texts(left) && is_texts(right)) {
            texts(path, left, right);
        } else if (left.is_array() && right.is_array()) {
            entries(path, key, left, right);
        } else {
            ++result_.values;
            if (left != right) difference(path, shown(left), shown(right));
        }
    }

    void members(const std::string& path, const Json& left, const Json& right) {
        for (const auto& [key, value] : left.items()) {
            if (path.empty() && key == "level") continue;
            const auto other = right.find(key);
            const std::string inner = member_path(path, key);
            if (other == right.end()) {
                only_in(inner, value, true);
            } else {
                values(inner, key, value, *other);
            }
        }
        for (const auto& [key, value] : right.items()) {
            if (path.empty() && key == "level") continue;
            if (!left.contains(key)) {
                only_in(member_path(path, key), value, false);
            }
        }
    }

    void entries(const std::string& path, const std::string& key, const Json& left, const Json& right) {
        const std::size_t both = std::min(left.size(), right.size());
        for (std::size_t i = 0; i < both; ++i) {
            values(path + "[" + parts_.entry(key, left[i], i) + "]", "", left[i], right[i]);
        }
        const bool left_is_longer = left.size() > both;
        const Json& longer = left_is_longer ? left : right;
        for (std::size_t i = both; i < longer.size(); ++i) {
            only_in(path + "[" + parts_.entry(key, longer[i], i) + "]", longer[i], left_is_longer);
        }
    }

    void texts(const std::string& path, const Json& left, const Json& right) {
        const std::size_t longest = std::max(left.size(), right.size());
        result_.values += longest;
        std::size_t differing = 0;
        std::size_t first = 0;
        for (std::size_t i = 0; i < longest; ++i) {
            const bool same = i < left.size() && i < right.size() && left[i] == right[i];
            if (!same && differing++ == 0) first = i;
        }
        if (differing == 0) return;
        const auto text_of = [first](const Json& list) {
            return first < list.size() ? shown(list[first]) : std::string("none");
        };
        std::string more;
        if (differing > 1) {
            more = "; " + std::to_string(differing) + " entries differ, " + names_.left + " has " +
                   std::to_string(left.size()) + " and " + names_.right + " " + std::to_string(right.size());
        }
        difference(path + "[" + std::to_string(first) + "]", text_of(left), text_of(right) + more);
    }

    /// A part as a whole is named, not spelled out.
    void only_in(const std::string& path, const Json& value, bool in_left) {
        ++result_.values;
        if (value.is_structured()) {
            result_.differences.push_back(path + ": only in " + (in_left ? names_.left : names_.right));
        } else {
            difference(path, in_left ? shown(value) : "none", in_left ? "none" : shown(value));
        }
    }

    void difference(const std::string& path, const std::string& left, const std::string& right) {
        result_.differences.push_back(path + ": " + names_.left + " " + left + ", " + names_.right + " " +
                                      right);
    }

    PartNames parts_;
    const ComparedNames& names_;
    ReportComparison result_;
};

Json parsed(const std::string& text) {
    Json report = Json::parse(text, nullptr, false);
    if (!report.is_object()) throw std::invalid_argument("a report is not a JSON object");
    return report;
}

std::string colour(std::uint32_t value) { return fmt::format("#{:06X}", value); }

std::string size_of(const ColourImage& image) {
    return std::to_string(image.width_pixels) + "x" + std::to_string(image.height_pixels);
}

}  // namespace

ReportComparison compare_reports(const std::string& left, const std::string& right,
                                 const ComparedNames& names) {
    const Json left_report = parsed(left);
    const Json right_report = parsed(right);
    Comparison comparison(left_report, names);
    comparison.compare(left_report, right_report);
    return std::move(comparison).result();
}

std::optional<std::string> picture_difference(int display, int frame, const ColourImage* left,
                                              const ColourImage* right, const ComparedNames& names) {
    if (left == right) return std::nullopt;
    const std::string where = "display_" + std::to_string(display) + " frame " + std::to_string(frame) + ": ";
    if (left == nullptr || right == nullptr) {
        return where + "shown by " + (left != nullptr ? names.left : names.right) + " only";
    }
    if (left->width_pixels != right->width_pixels || left->height_pixels != right->height_pixels) {
        return where + names.left + " " + size_of(*left) + ", " + names.right + " " + size_of(*right) +
               " pixels";
    }
    const std::optional<ImageDifference> difference = image_difference(*left, *right);
    if (!difference) return std::nullopt;
    return where + std::to_string(difference->pixels) +
           (difference->pixels == 1 ? " pixel differs" : " pixels differ, first") + " at " +
           std::to_string(difference->x) + "," + std::to_string(difference->y) + ": " + names.left + " " +
           colour(difference->left) + ", " + names.right + " " + colour(difference->right);
}

}  // namespace metabuffer
