#include "scenario/scenario_loader.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "host/errors.h"
#include "host/text.h"
#include "images/images_ahead.h"
#include "scenario/scenario_keys.h"
#include "scenario/scenario_template.h"

namespace metabuffer {
namespace {

/// The images that each run of the scenario needs, each once, in the order in which frames need them.
std::vector<std::shared_ptr<const StoredImage>> images_in_order(const Scenario& scenario) {
    std::vector<std::shared_ptr<const StoredImage>> images;
    std::set<const StoredImage*> known;
    std::size_t pairs = 0;
    for (const Renderer& renderer : scenario.renderers) pairs = std::max(pairs, renderer.frames.size());
    pairs = std::min(pairs, static_cast<std::size_t>(scenario.frames));
    for (std::size_t pair = 0; pair < pairs; ++pair) {
        for (const Renderer& renderer : scenario.renderers) {
            if (pair >= renderer.frames.size()) continue;
            const auto& image = renderer.images[renderer.frames[pair].image];
            if (known.insert(image.get()).second) images.push_back(image);
        }
    }
    return images;
}

}  // namespace

ScenarioOverride parse_override(const std::string& text) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
        throw InputError(text::one_line(
            "--set " + text + ": has no value; use --set PATH=VALUE, like --set bus.width_bits=32"));
    }
    if (equals == 0) {
        throw InputError(text::one_line(
            "--set " + text + ": has no key path; use --set PATH=VALUE, like --set bus.width_bits=32"));
    }
    return {text.substr(0, equals), text.substr(equals + 1)};
}

Scenario parse_scenario(const std::string& text, const std::string& origin, const std::filesystem::path& base,
                        const std::vector<ScenarioOverride>& overrides) {
    return ScenarioTemplate(text, origin, base).scenario(overrides);
}

Scenario load_scenario(const std::filesystem::path& file, const std::vector<ScenarioOverride>& overrides,
                       LiveRenderers live) {
    return ScenarioTemplate(file).scenario(overrides, live);
}

void read_images(const Scenario& scenario) {
    for (const auto& image : images_in_order(scenario)) image->pixels();
}

void read_images_ahead(Scenario& scenario, std::size_t processes) {
    constexpr std::int64_t kLeastPixels = 1'000'000;
    std::vector<std::shared_ptr<const StoredImage>> images = images_in_order(scenario);
    images.erase(
        std::remove_if(images.begin(), images.end(), [](const auto& image) { return image->is_read(); }),
        images.end());
    std::int64_t pixels = 0;
    for (const auto& image : images) pixels += std::int64_t{image->width_pixels()} * image->height_pixels();
    if (pixels < kLeastPixels) return;

    std::map<const StoredImage*, std::shared_ptr<const StoredImage>> ahead;
    const std::vector<std::shared_ptr<const StoredImage>> read = read_ahead(images, processes);
    for (std::size_t n = 0; n < images.size(); ++n) {
        ahead[images[n].get()] = read[n];
        if (const auto files = scenario.image_files.extract(images[n].get())) {
            scenario.image_files.emplace(read[n].get(), files.mapped());
        }
    }
    for (Renderer& renderer : scenario.renderers) {
        for (auto& image : renderer.images) {
            if (const auto found = ahead.find(image.get()); found != ahead.end()) image = found->second;
        }
    }
}

std::vector<std::string> scenario_key_paths() { return scenario_schema().paths(); }

}  // namespace metabuffer
