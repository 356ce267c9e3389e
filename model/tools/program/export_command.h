#pragma once

#include <string>
#include <vector>

#include "tools/exploration/results_database.h"
#include "tools/exploration/table_text.h"
#include "tools/program/command.h"

namespace metabuffer {

/// `metabuffer export`: the results of a sweep or a search as CSV or JSON.
class ExportCommand final : public Command {
  public:
    /// Adds the subcommand and its options.
    explicit ExportCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    std::string format() const;
    void write(const exploration::ResultsReader& reader, const exploration::TableText::Sink& sink) const;

    std::vector<std::string> results_files_;
    std::string format_;       ///< empty if it is not given
    std::string output_file_;  ///< empty: standard output
    std::string condition_;
    std::string columns_;  ///< expressions with commas in between; empty: all columns
    bool runs_ = false;
    bool bookkeeping_ = false;
};

}  // namespace metabuffer
