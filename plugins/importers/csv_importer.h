/// Importer "csv": tables of real vehicles, as a column map says what is in them.
#pragma once

#include "api/importer.h"

namespace loopline {

/// Sensors become observations, merged by when they were known and each in its file's order; a reference
/// becomes the truth beside the rawlog. What a map can say stands in docs/column-maps.md.
class CsvImporter : public Importer {
    DEFINE_MRPT_OBJECT(CsvImporter, loopline)
 public:
    ModuleInfo info() const override;
    ParameterTable parameters() override;
    std::string check() const override;
    bool takes_folders() const override { return true; }
    std::string import(const std::vector<std::string>& inputs, RawlogSink& sink) override;

 private:
    std::string columns_;
};

}  // namespace loopline
