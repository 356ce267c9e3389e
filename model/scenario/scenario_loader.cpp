#include "scenario/scenario_loader.h"

#include <cstddef>

#include "host/errors.h"
#include "host/text.h"
#include "scenario/scenario_keys.h"
#include "scenario/scenario_template.h"

namespace metabuffer {

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

Scenario load_scenario(const std::filesystem::path& file, const std::vector<ScenarioOverride>& overrides) {
    return ScenarioTemplate(file).scenario(overrides);
}

std::vector<std::string> scenario_key_paths() { return scenario_schema().paths(); }

}  // namespace metabuffer
