/*!
  \file Cabana_Core.hpp
  \brief The one header to include: the subset of Cabana that Machpoint uses,
  with Cabana's names and semantics. See README.md beside this file.
*/
#ifndef CABANA_CORE_HPP
#define CABANA_CORE_HPP

#include <Cabana_AoSoA.hpp>
#include <Cabana_DeepCopy.hpp>
#include <Cabana_ExecutionPolicy.hpp>
#include <Cabana_MemberTypes.hpp>
#include <Cabana_Parallel.hpp>
#include <Cabana_Slice.hpp>
#include <Cabana_SoA.hpp>
#include <Cabana_Sort.hpp>
#include <Cabana_Tuple.hpp>
#include <Cabana_Types.hpp>

#ifdef MACHPOINT_ENABLE_MPI
#include <Cabana_Distributor.hpp>
#endif

#endif
