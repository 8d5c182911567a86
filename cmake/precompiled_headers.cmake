# Large headers of other libraries are parsed once per kind of target instead of once per source, which saves a third of
# the build's time. Sources still include what they use; a build with -DVOXNAV_PRECOMPILED_HEADERS=OFF checks that.
option(VOXNAV_PRECOMPILED_HEADERS "Parse the headers of the libraries used once per kind of target" ON)

# voxnav_precompile(target header...) precompiles headers for a target.
function(voxnav_precompile target)
  if(VOXNAV_PRECOMPILED_HEADERS)
    # This definition differs between targets, which then could not share their precompiled headers.
    set_target_properties(${target} PROPERTIES DEFINE_SYMBOL "")
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

# voxnav_share_precompiled(target owner) uses the precompiled headers of the owner, which needs the same options.
function(voxnav_share_precompiled target owner)
  if(VOXNAV_PRECOMPILED_HEADERS)
    set_target_properties(${target} PROPERTIES DEFINE_SYMBOL "")
    target_precompile_headers(${target} REUSE_FROM ${owner})
  endif()
endfunction()
