# Completion for interactive bash, sourced by install/setup.bash: `mobo`, and of `ros2` what the stand-in offers.
case $- in *i*) ;; *) return 0 ;; esac

# The first Tab asks mobo for its own function, which takes the place of this one; 124 has bash begin again with it.
_mobo_first_tab() {
  eval "$(mobo completion bash 2>/dev/null)"
  [[ "$(complete -p mobo 2>/dev/null)" != *_mobo_first_tab* ]] && return 124
}
complete -F _mobo_first_tab mobo

# ros2 run PKG EXE, ros2 pkg executables PKG: from the folders of AMENT_PREFIX_PATH.
_mobo_ros2() {
  local IFS=$'\n' path names="" prefix
  local -a prefixes
  IFS=: read -r -a prefixes <<<"${AMENT_PREFIX_PATH:-}"
  case "${COMP_WORDS[1]} $COMP_CWORD" in
    *" 1") names=$'run\npkg' ;;
    "pkg 2") names=executables ;;
    "run 2" | "pkg 3")
      for prefix in "${prefixes[@]}"; do
        for path in "$prefix"/share/ament_index/resource_index/packages/*; do
          [ ! -d "$prefix/lib/${path##*/}" ] || names+="${path##*/}"$'\n'
        done
      done
      ;;
    "run 3")
      for prefix in "${prefixes[@]}"; do
        for path in "$prefix/lib/${COMP_WORDS[2]}"/*; do
          [ ! -f "$path" ] || [ ! -x "$path" ] || names+="${path##*/}"$'\n'
        done
      done
      ;;
  esac
  mapfile -t COMPREPLY < <(compgen -W "$names" -- "${COMP_WORDS[COMP_CWORD]}")
}
# A real ros2 brings its own.
complete -p ros2 >/dev/null 2>&1 || complete -o default -F _mobo_ros2 ros2
