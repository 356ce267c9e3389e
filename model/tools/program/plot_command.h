#pragma once

#include <string>
#include <vector>

#include "tools/charts/plot.h"
#include "tools/program/command.h"

namespace metabuffer {

/// `metabuffer plot`: one chart of results as SVG or PNG.
class PlotCommand final : public Command {
  public:
    explicit PlotCommand(CLI::App& program);

    ExitStatus execute() override;

  private:
    void add_chart_options();

    std::vector<std::string> results_files_;
    std::string output_file_;
    std::string chart_ = "lines";
    std::string y_;
    std::vector<std::string> references_;
    charts::PlotRequest request_;
};

}  // namespace metabuffer
