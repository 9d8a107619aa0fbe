#include "sim/fem/fem_plan.h"

namespace wry::fem {

bool is_micropolar(ElasticModel model) {
  return model == ElasticModel::micropolar || model == ElasticModel::micropolar_det ||
         model == ElasticModel::micropolar_neo_hookean;
}

} // namespace wry::fem
