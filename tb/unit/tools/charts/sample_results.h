#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "support/scratch_directory.h"
#include "tools/exploration/figures.h"
#include "tools/exploration/results_database.h"

namespace metabuffer::test {

/// A figure by its name; the others of a run are 1.
using Figures = std::map<std::string, exploration::Value>;

inline std::vector<exploration::Value> figures(const Figures& known) {
    std::vector<exploration::Value> values;
    for (const exploration::FigureKind& kind : exploration::figure_kinds()) {
        const auto value = known.find(kind.name);
        values.push_back(value == known.end() ? exploration::Value(std::int64_t{1}) : value->second);
    }
    return values;
}

/// A run that came to its end, nothing starved or rejected unless `known` says so.
inline exploration::RunRecord done_run(std::vector<exploration::Setting> settings, Figures known) {
    bool is_whole = true;
    for (const char* name : {"starved_pixels", "rejected_frames", "rejected_rows"}) {
        is_whole =
            known.emplace(name, std::int64_t{0}).first->second == exploration::Value(std::int64_t{0}) &&
            is_whole;
    }
    known.emplace(exploration::kWhole, std::int64_t{is_whole});
    exploration::RunRecord run;
    run.settings = std::move(settings);
    run.figures = figures(known);
    run.report = "{\"renderers\": []}\n";
    run.wall_seconds = 0.25;
    return run;
}

/// The point of one run.
inline exploration::PointRecord point_of(const exploration::RunRecord& run) {
    exploration::PointRecord point;
    point.settings = run.settings;
    point.status = run.status;
    point.reason = run.reason;
    return point;
}

/// A file of results over these keys, a point for each run.
inline std::filesystem::path write_results(const ScratchDirectory& scratch, std::vector<std::string> keys,
                                           const std::vector<exploration::RunRecord>& runs) {
    exploration::ResultsIdentity identity;
    identity.keys = std::move(keys);
    exploration::ResultsDatabase database =
        exploration::ResultsDatabase::open(scratch / "results.db", identity);
    for (const exploration::RunRecord& run : runs) database.add_point(point_of(run), run);
    return scratch / "results.db";
}

/// Two widths by two policies, all done except the last point, which failed.
inline std::filesystem::path sample_results(const ScratchDirectory& scratch,
                                            const std::string& file = "results.db",
                                            const std::string& name = "sample",
                                            const std::string& reason = "no such machine") {
    exploration::ResultsIdentity identity;
    identity.name = name;
    identity.fingerprint = "1";
    identity.keys = {"bus.width_bits", "bus.arbitration"};
    exploration::ResultsDatabase database = exploration::ResultsDatabase::open(scratch / file, identity);
    for (const char* width : {"32", "64"}) {
        for (const char* policy : {"irsa", "edf"}) {
            const bool is_narrow = std::string(width) == "32";
            const bool is_last = !is_narrow && std::string(policy) == "edf";
            exploration::RunRecord run = done_run({{"bus.width_bits", width}, {"bus.arbitration", policy}},
                                                  {{"starved_pixels", std::int64_t{is_narrow ? 700 : 0}},
                                                   {"frames_per_second", is_narrow ? 400.5 : 900.25},
                                                   {"cost", std::int64_t{is_narrow ? 1000 : 2000}},
                                                   {"utilization", 0.5}});
            if (is_last) {
                run.status = exploration::RunStatus::kInvalid;
                run.reason = reason;
                run.figures.clear();
                run.report.clear();
            }
            database.add_point(point_of(run), run);
        }
    }
    return scratch / file;
}

}  // namespace metabuffer::test
