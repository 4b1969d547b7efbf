# Completion for interactive zsh, sourced by install/setup.zsh: `mobo`, and of `ros2` what the stand-in offers.
# It needs zsh's own completion (autoload -U compinit; compinit) to be on before.
if [[ -o interactive ]] && (( $+functions[compdef] )); then
  # The first Tab asks mobo for its own function, which takes the place of this one.
  _mobo_first_tab() {
    eval "$(mobo completion zsh 2>/dev/null)"
    (( $+functions[_python_argcomplete] )) && _python_argcomplete "$@"
  }
  compdef _mobo_first_tab mobo

  # ros2 run PKG EXE, ros2 pkg executables PKG: from the folders of AMENT_PREFIX_PATH.
  _mobo_ros2() {
    local prefix marker
    local -a names
    case "$words[2] $CURRENT" in
      *" 2") names=(run pkg) ;;
      "pkg 3") names=(executables) ;;
      "run 3" | "pkg 4")
        for prefix in ${(s.:.)AMENT_PREFIX_PATH}; do
          for marker in $prefix/share/ament_index/resource_index/packages/*(N:t); do
            [[ -d $prefix/lib/$marker ]] && names+=($marker)
          done
        done
        ;;
      "run 4")
        for prefix in ${(s.:.)AMENT_PREFIX_PATH}; do
          names+=($prefix/lib/$words[3]/*(N-.x:t))
        done
        ;;
      *) _files; return ;;
    esac
    compadd -a names
  }
  # A real ros2 brings its own.
  (( $+_comps[ros2] )) || compdef _mobo_ros2 ros2
fi
