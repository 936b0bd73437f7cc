#include "fusion/fused_path.h"

namespace loopline::fusion {

const char* name_of(FixUse use) {
    switch (use) {
        case FixUse::used:
            return "used";
        case FixUse::no_position:
            return "no_position";
        case FixUse::before_path:
            return "before_path";
        case FixUse::after_path:
            return "after_path";
        case FixUse::late:
            return "late";
        case FixUse::off_the_path:
            return "off_the_path";
        case FixUse::out_of_sync:
            return "out_of_sync";
        case FixUse::withheld:
            return "withheld";
        case FixUse::heading_never_found:
            break;
    }
    return "heading_never_found";
}

}  // namespace loopline::fusion
