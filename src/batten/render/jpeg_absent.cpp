#include "batten/core/error.hpp"
#include "batten/render/jpeg_detail.hpp"

namespace batten::detail {

GreyImage decode_jpeg(const std::string&, const std::string& name) {
  throw FileError(name, 0,
                  "is a JPEG, which this program was built without; convert it to PNG or PGM, or build with "
                  "libjpeg-dev installed");
}

}  // namespace batten::detail
